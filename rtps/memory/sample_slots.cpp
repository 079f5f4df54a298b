#include "rtps/memory/sample_slots.hpp"

#include <algorithm>
#include <bit>

namespace ddssec::rtps::memory {
namespace {

// There are four sizes for each power of two, so that at most a quarter of a slot is wasted.
std::size_t rounded(std::size_t size) {
  constexpr std::size_t kMin = 4096;
  const auto step = std::max(kMin, std::bit_floor(size) / 4);
  return (size + step - 1) / step * step;
}

std::size_t slots_of(std::size_t size) {
  return std::clamp(SampleSlots::kOctets / size, SampleSlots::kMin, SampleSlots::kMax);
}

}  // namespace

std::size_t SampleSlots::size_for(std::size_t largest) {
  const auto size = rounded(largest);
  return slots_of(size) * (size + kSlotHead);
}

MemoryResult<SampleSlots> SampleSlots::make(std::uint64_t id, std::size_t largest) {
  if (largest == 0 || largest > kMaxSegment) return refuse(MemoryRefusal::bad_shape);
  const auto size = rounded(largest);
  auto segment = Segment::make(id, size, slots_of(size));
  if (!segment) return refuse(segment.error());
  return SampleSlots(*std::move(segment));
}

MemoryResult<MutableBytes> SampleSlots::begin(SequenceNumber needed_from, MonotonicTime now) {
  while (count_ > 0 && oldest().number < needed_from) release_oldest();
  if (count_ == used_.size() && now - oldest().since >= kMaxUse) release_oldest();
  return segment_.begin();
}

Reference SampleSlots::end(SequenceNumber number, std::size_t length, MonotonicTime now) {
  const auto reference = segment_.end(length);
  used_[(first_ + count_) % used_.size()] = {number, now, reference};
  ++count_;
  return reference;
}

void SampleSlots::wipe() {
  while (count_ > 0) release_oldest();
  segment_.wipe();
}

void SampleSlots::release_oldest() {
  segment_.release(oldest().reference);
  first_ = (first_ + 1) % used_.size();
  --count_;
}

}  // namespace ddssec::rtps::memory
