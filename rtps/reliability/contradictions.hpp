// Whether the messages of a writer, in whose name anyone can send, contradict each other.
#pragma once

#include <map>

#include "wire/data.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"

namespace ddssec::rtps {

/// A reader takes each sequence number once. So what a forged message says about a number, the
/// writer's own message cannot correct. But that message arrives, too, and differs. Nothing
/// shows which of the two is forged. So the reader can only request everything again.
///
/// Messages that the network reorders may look like a contradiction, too.
class Contradictions {
 public:
  /// Limit for the changes whose content is remembered, the latest ones.
  static constexpr std::size_t kMaxRemembered = 256;

  // All but the last return true if the message contradicts an earlier one.
  /// `next`: the reader has taken or given up everything below this number.
  bool note(const Data& data, SequenceNumber next);
  bool note(const DataFrag& frag, SequenceNumber next);
  bool note(const Heartbeat& heartbeat);
  void note(const Gap& gap);

 private:
  bool note(SequenceNumber number, std::uint64_t content, SequenceNumber next);

  SequenceNumber highest_;  ///< the highest number that the writer is said to have used
  std::map<SequenceNumber, std::uint64_t> contents_;  ///< a part of the digest of each change
};

}  // namespace ddssec::rtps
