// Changes for readers whose content filters the writer applies (RTPS 8.7.3.3).
#pragma once

#include <vector>

#include "rtps/reliability/matched_readers.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// A reader that does not get a change is told so by a GAP, at the latest before a heartbeat that
/// would make it request the change. What it refers to outlives it.
class FilteredWriting {
 public:
  FilteredWriting(MatchedReaders& readers, WriterMessages& messages)
      : readers_(readers), messages_(messages) {}

  /// Sends a change that was just written to the readers that get it.
  void send(const Change& change);
  /// GAPs that were not sent yet, up to `end`: of one reader, of all.
  void send_gap(ReaderProxy& proxy, SequenceNumber end);
  void send_gaps(SequenceNumber end);

 private:
  /// True if all get it.
  bool judge(const Change& change);

  MatchedReaders& readers_;
  WriterMessages& messages_;
  LocatorList wanted_;  ///< locators of the readers that get the last change
  std::vector<FilterResult> results_;
};

}  // namespace ddssec::rtps
