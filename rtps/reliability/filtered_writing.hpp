// Sends changes to readers whose content filters the writer applies (RTPS 8.7.3.3).
#pragma once

#include <vector>

#include "rtps/reliability/matched_readers.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// Decides which readers get a change. A reader that does not get it gets a GAP for it, at the
/// latest before a HEARTBEAT that would make it request the change. The constructor's arguments
/// must outlive this object.
class FilteredWriting {
 public:
  /// The limit for the octets of samples that are decoded for one change, for all filters together.
  /// One filter is always evaluated. Readers whose filters are not get the change and decide.
  static constexpr std::size_t kMaxDecoded = std::size_t{1} << 20;

  FilteredWriting(MatchedReaders& readers, WriterMessages& messages)
      : readers_(readers), messages_(messages) {}

  /// Sends a change that was just written to the readers that get it. `memory` is the place of its
  /// payload for readers that find it there; empty if there is none.
  void send(const Change& change, const std::optional<MemoryReference>& memory = {});
  /// Sends the GAPs up to `end` that were not sent yet: to one reader, or to all.
  void send_gap(ReaderProxy& proxy, SequenceNumber end);
  void send_gaps(SequenceNumber end);

 private:
  /// Decides which readers get the change. Returns true if all do.
  bool select_readers(const Change& change, bool in_memory);

  MatchedReaders& readers_;
  WriterMessages& messages_;
  /// Locators of the readers that get the last change in messages, or from memory.
  LocatorList wanted_, wanted_in_memory_;
  std::vector<FilterResult> results_;
};

}  // namespace ddssec::rtps
