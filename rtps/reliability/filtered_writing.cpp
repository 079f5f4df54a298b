#include "rtps/reliability/filtered_writing.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::rtps {

// Disposed and unregistered instances concern all: 8.7.4 asks for less, and a reader knows best
// whether it ever saw the instance.
bool FilteredWriting::judge(const Change& change) {
  results_.clear();
  wanted_.clear();
  bool all = true;
  for (auto& [guid, proxy] : readers_.all()) {
    const auto result = proxy.filter_result(change);
    const bool passed = proxy.wanted = proxy.is_for(change) && result.value_or(true);
    if (result) results_.push_back({proxy.reader().filter->signature, passed});
    all = all && passed;
    if (!passed && proxy.filtered_from.value == 0) proxy.filtered_from = change.sequence_number;
    const auto& locators = proxy.reader().locators;
    if (passed) wanted_.insert(wanted_.end(), locators.begin(), locators.end());
  }
  std::ranges::sort(wanted_);
  const auto repeated = std::ranges::unique(wanted_);
  wanted_.erase(repeated.begin(), repeated.end());
  return all;
}

// Readers that share a locator with one that wants the sample get it too, and drop it: it says that
// it did not pass, and their own filter says so as well.
void FilteredWriting::send(const Change& change) {
  const bool all = judge(change);
  for (auto& [guid, proxy] : readers_.all())
    if (proxy.wanted) send_gap(proxy, change.sequence_number);
  if (all)
    messages_.change(readers_.everybody(), change, results_);
  else if (!wanted_.empty())
    messages_.change({{{}, wanted_}}, change, results_);
}

void FilteredWriting::send_gap(ReaderProxy& proxy, SequenceNumber end) {
  if (proxy.filtered_from.value == 0) return;
  const auto from = std::exchange(proxy.filtered_from, SequenceNumber{});
  messages_.gap(readers_.one(proxy), from, end);
}

void FilteredWriting::send_gaps(SequenceNumber end) {
  if (readers_.filtered() == 0) return;
  for (auto& [guid, proxy] : readers_.all()) send_gap(proxy, end);
}

}  // namespace ddssec::rtps
