// The messages of a reader: ACKNACK and NACK_FRAG (RTPS 8.3.8.1, 8.3.8.10).
#pragma once

#include "rtps/reliability/message_sender.hpp"
#include "wire/acknack.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

/// Adds submessages to the sender, which must outlive this object and which the caller flushes. All
/// writers share the counts, so that a writer that returns receives later ones.
class ReaderMessages {
 public:
  ReaderMessages(const EntityId& reader, MessageSender& sender)
      : reader_(reader), sender_(sender) {}

  /// Acknowledges everything below the base of `missing`. `is_final` means that no answer is
  /// needed.
  void acknack(const Destination& to, const EntityId& writer, const SequenceNumberSet& missing,
               bool is_final) {
    sender_.add(to, AckNack{reader_, writer, missing, ++count_, is_final});
  }
  void nack_frag(const Destination& to, const EntityId& writer, SequenceNumber sample,
                 const FragmentNumberSet& missing) {
    sender_.add(to, NackFrag{reader_, writer, sample, missing, ++count_});
  }

 private:
  const EntityId reader_;
  MessageSender& sender_;
  std::int32_t count_ = 0;
};

}  // namespace ddssec::rtps
