#include "rtps/reliability/partial_samples.hpp"

#include <algorithm>

namespace ddssec::rtps {

PartialSamples::Samples::const_iterator PartialSamples::find(SequenceNumber number) const {
  return std::ranges::find(samples_, number, &Sample::number);
}

PartialSamples::Samples::iterator PartialSamples::find(SequenceNumber number) {
  return std::ranges::find(samples_, number, &Sample::number);
}

bool PartialSamples::admits(const DataFrag& frag) const {
  if (const auto known = find(frag.sequence_number); known != samples_.end())
    return known->fragment_size == frag.fragment_size &&
           known->change.payload.size() == frag.sample_size;
  return frag.total() <= kMaxSmallFragments || frag.fragment_size >= kMinFragmentSize;
}

bool PartialSamples::begin(const GuidPrefix& from, const DataFrag& frag,
                           const std::optional<Time>& time) {
  if (samples_.size() >= kMaxSamples) {
    if (!prefers_newest_ && last() < frag.sequence_number) return false;
    const auto gone = prefers_newest_ ? first() : last();
    erase(gone, gone);
  }
  const auto price = kPrice + frag.sample_size + frag.total() / 8;
  account_.hold(price);
  const auto before = std::ranges::lower_bound(samples_, frag.sequence_number, {}, &Sample::number);
  samples_.insert(before, Sample{received_change(from, frag, time), frag.fragment_size,
                                 FragmentSet(frag.total()), price});
  return true;
}

bool PartialSamples::insert(const DataFrag& frag) {
  const auto sample = find(frag.sequence_number);
  if (sample == samples_.end()) return false;
  const auto begin = std::size_t{frag.first.value - 1} * frag.fragment_size;
  std::ranges::copy(frag.payload, sample->change.payload.fill().subspan(begin).begin());
  return sample->have.insert(frag.first, frag.count);
}

std::optional<Change> PartialSamples::take_complete(SequenceNumber number) {
  const auto sample = find(number);
  if (sample == samples_.end() || !sample->have.is_complete()) return std::nullopt;
  auto out = std::move(sample->change);
  account_.release(sample->price);
  samples_.erase(sample);
  return out;
}

void PartialSamples::erase(SequenceNumber first, SequenceNumber last) {
  std::erase_if(samples_, [&](const auto& sample) {
    const bool gone = first <= sample.number() && sample.number() <= last;
    if (gone) account_.release(sample.price);
    return gone;
  });
}

}  // namespace ddssec::rtps
