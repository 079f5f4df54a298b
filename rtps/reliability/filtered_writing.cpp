// StatefulWriter, the part for readers whose content filters it applies (RTPS 2.5, 8.7.3.3).
#include <algorithm>

#include "rtps/reliability/stateful_writer.hpp"
#include "wire/gap.hpp"

namespace ddssec::rtps {

void StatefulWriter::set_filter(const Guid& reader, std::shared_ptr<ChangeFilter> filter) {
  auto* proxy = find(reader);
  if (proxy == nullptr) return;
  if (proxy->filtered_from.value != 0) send_filtered_gap(*proxy, history_.last().next());
  sender_.flush();
  if (!proxy->reader.filter && filters_ >= kMostFilters) return;
  filters_ -= proxy->is_filtered() ? 1 : 0;
  proxy->reader.filter = std::move(filter);
  filters_ += proxy->is_filtered() ? 1 : 0;
}

// Disposed and unregistered instances concern all: 8.7.4 asks for less, and a reader knows best
// whether it ever saw the instance.
bool StatefulWriter::filter(const Change& change) {
  filter_results_.clear();
  wanted_locators_.clear();
  bool all = true;
  for (auto& [guid, proxy] : readers_) {
    const auto result = proxy.filtered(change);
    const bool passed = proxy.wanted = proxy.is_for(change) && result.value_or(true);
    if (result) filter_results_.push_back({proxy.reader.filter->signature, passed});
    all = all && passed;
    if (!passed && proxy.filtered_from.value == 0) proxy.filtered_from = change.sequence_number;
    if (passed)
      wanted_locators_.insert(wanted_locators_.end(), proxy.reader.locators.begin(),
                              proxy.reader.locators.end());
  }
  std::ranges::sort(wanted_locators_);
  const auto repeated = std::ranges::unique(wanted_locators_);
  wanted_locators_.erase(repeated.begin(), repeated.end());
  return all;
}

// Readers that share a locator with one that wants the sample get it too, and drop it: it says that
// it did not pass, and their own filter says so as well.
void StatefulWriter::send_filtered(const Change& change) {
  const bool all = filter(change);
  for (auto& [guid, proxy] : readers_)
    if (proxy.wanted && proxy.filtered_from.value != 0)
      send_filtered_gap(proxy, change.sequence_number);
  if (all)
    send_change(to_all(), all_readers(), change);
  else if (!wanted_locators_.empty())
    send_change({{}, wanted_locators_}, kEntityIdUnknown, change);
  filter_results_.clear();  // what is sent again goes to one reader, which it passed
}

void StatefulWriter::send_filtered_gap(ReaderProxy& proxy, SequenceNumber next) {
  const auto from = std::exchange(proxy.filtered_from, SequenceNumber{});
  sender_.add(to(proxy), gap_of(proxy.reader.guid.entity, from, next));
}

void StatefulWriter::send_filtered_gaps() {
  if (filters_ == 0) return;
  for (auto& [guid, proxy] : readers_)
    if (proxy.filtered_from.value != 0) send_filtered_gap(proxy, history_.last().next());
}

}  // namespace ddssec::rtps
