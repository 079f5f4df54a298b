// Changes that readers request again (RTPS 8.4.9.2.11).
#pragma once

#include "rtps/reliability/reader_proxy.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// Answers come in portions, each followed by a heartbeat that asks for the next request, so that
/// the reader's pace sets the writer's. The heartbeats are sent by the caller.
class Retransmissions {
 public:
  static constexpr std::size_t kMaxOctetsPerAnswer = 128 << 10;
  /// What a repeated sample counts for at least, with its header.
  static constexpr std::size_t kMinOctets = 64;

  /// Both outlive it.
  Retransmissions(const WriterHistory& history, WriterMessages& messages)
      : history_(history), messages_(messages) {}

  /// The lowest change that the reader may get.
  SequenceNumber lowest_for(const ReaderProxy& proxy) const {
    return std::max(history_.first(), proxy.first_relevant());
  }
  /// Sends what an ACKNACK requests, or a GAP for what the reader does not get. False: the request
  /// was just answered.
  bool answer(ReaderProxy& proxy, const Receiver& receiver, const SequenceNumberSet& missing,
              MonotonicTime now);
  /// Takes the request of a NACK_FRAG, of which portions are to be sent. False: the request is
  /// being answered, or the reader had too much lately.
  bool begin(ReaderProxy& proxy, const NackFrag& nack, MonotonicTime now);
  /// Sends a portion of the fragments. False: nothing was due.
  bool send_portion(ReaderProxy& proxy, const Receiver& receiver, MonotonicTime now);

 private:
  const WriterHistory& history_;
  WriterMessages& messages_;
};

}  // namespace ddssec::rtps
