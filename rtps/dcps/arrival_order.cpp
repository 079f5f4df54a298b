#include "rtps/dcps/arrival_order.hpp"

namespace ddssec::rtps {

void ArrivalOrder::insert(HeldInstance& instance, HeldSamples::iterator sample) {
  auto& entries = sample->is_read ? read_ : unread_;
  entries.emplace_hint(entries.end(), sample->arrival, Entry{&instance, sample});
}

void ArrivalOrder::erase(const HeldSample& sample) {
  (sample.is_read ? read_ : unread_).erase(sample.arrival);
}

// Moves the node from one map to the other, so that reading allocates nothing.
void ArrivalOrder::mark_read(const HeldSample& sample) {
  read_.insert(unread_.extract(sample.arrival));
}

void ArrivalOrder::clear() {
  unread_.clear();
  read_.clear();
}

std::vector<ArrivalOrder::Entry> ArrivalOrder::first(const States& states,
                                                     std::size_t max_samples) const {
  std::vector<Entry> out;
  auto unread = states.sample.contains(SampleState::not_read) ? unread_.begin() : unread_.end();
  auto read = states.sample.contains(SampleState::read) ? read_.begin() : read_.end();
  while (out.size() < max_samples && (unread != unread_.end() || read != read_.end())) {
    const bool take_read =
        unread == unread_.end() || (read != read_.end() && read->first < unread->first);
    const auto& entry = (take_read ? read++ : unread++)->second;
    if (states.view.contains(entry.instance->view) &&
        states.instance.contains(entry.instance->state))
      out.push_back(entry);
  }
  return out;
}

}  // namespace ddssec::rtps
