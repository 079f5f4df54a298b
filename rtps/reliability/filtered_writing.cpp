#include "rtps/reliability/filtered_writing.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::rtps {

// Disposes and unregistrations are sent to all readers. 8.7.4 requires less, but only the reader
// knows whether it ever saw the instance.
bool FilteredWriting::select_readers(const Change& change, bool in_memory) {
  results_.clear();
  wanted_.clear();
  wanted_in_memory_.clear();
  bool all = true;
  std::size_t decoded = 0;
  for (auto& [guid, proxy] : readers_.all()) {
    const bool is_evaluated = proxy.reader().filter && decoded < kMaxDecoded;
    const auto result = is_evaluated ? proxy.filter_result(change) : std::nullopt;
    if (is_evaluated) decoded += change.payload.size();
    if (result == false) proxy.note_rejected(change.sequence_number);
    const bool passed = proxy.wanted = proxy.is_for(change) && result.value_or(true);
    if (result) results_.push_back({proxy.reader().filter->signature, passed});
    all = all && passed;
    if (!passed && proxy.filtered_from.value == 0) proxy.filtered_from = change.sequence_number;
    const auto& locators = proxy.reader().locators;
    auto& wanted = in_memory && proxy.in_memory ? wanted_in_memory_ : wanted_;
    if (passed && !proxy.is_limited) wanted.insert(wanted.end(), locators.begin(), locators.end());
  }
  for (auto* wanted : {&wanted_, &wanted_in_memory_}) {
    std::ranges::sort(*wanted);
    const auto repeated = std::ranges::unique(*wanted);
    wanted->erase(repeated.begin(), repeated.end());
  }
  return all;
}

// A reader that shares a locator with a reader that gets the sample receives the sample too. It
// drops the sample, which carries the filter result, and its own filter also rejects it.
void FilteredWriting::send(const Change& change, const std::optional<MemoryReference>& memory) {
  readers_.release_proven();
  const bool all = select_readers(change, memory.has_value());
  for (auto& [guid, proxy] : readers_.all())
    if (proxy.wanted) send_gap(proxy, change.sequence_number);
  const auto send_whole = [&](const Receiver& to) { messages_.change(to, change, results_); };
  readers_.for_each_limited([&](const ReaderProxy& proxy) {
    if (proxy.wanted) send_whole(readers_.one(proxy));
  });
  if (!wanted_.empty())
    send_whole(all && !memory ? readers_.all_readers() : Receiver{{{}, wanted_}});
  if (!wanted_in_memory_.empty())
    messages_.reference({{{}, wanted_in_memory_}}, change, *memory, results_);
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
