// Notices when messages in the name of one writer contradict each other, because anyone can send
// them.
#pragma once

#include <map>

#include "wire/data.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"

namespace ddssec::rtps {

/// Remembers what the messages in the name of one writer say. A reader takes each sequence number
/// once. So the writer's own message cannot correct what a forged one says about a number. But both
/// arrive, and they differ. Nothing shows which of the two is forged, so the reader can only
/// request everything again.
///
/// Messages that the network reorders may look like a contradiction, too.
class Contradictions {
 public:
  /// Limit for the changes whose content is remembered, the latest ones.
  static constexpr std::size_t kMaxRemembered = 256;

  // All but the last return true if the message contradicts an earlier one.
  /// `next` is the number below which the reader has taken or given up everything.
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
