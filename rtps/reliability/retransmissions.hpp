// Retransmits changes that readers request (RTPS 8.4.9.2.11).
#pragma once

#include <algorithm>

#include "rtps/reliability/reader_proxy.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// Answers are sent in portions. Each is followed by a HEARTBEAT that triggers the next request, so
/// that the reader sets the pace. The caller sends the HEARTBEATs.
class Retransmissions {
 public:
  static constexpr std::size_t kMaxOctetsPerAnswer = 128 << 10;
  /// The smallest number of octets that a repeated sample counts, including its header.
  static constexpr std::size_t kMinOctets = 64;

  /// All must outlive this object.
  Retransmissions(const WriterHistory& history, WriterMessages& messages,
                  EvaluationAllowance& evaluations)
      : history_(history), messages_(messages), evaluations_(evaluations) {}

  /// Returns the lowest change that the reader may get.
  SequenceNumber lowest_for(const ReaderProxy& proxy) const {
    return std::max(history_.first(), proxy.first_relevant());
  }
  /// Sends the changes that an ACKNACK requests, and GAPs for those that the reader does not get:
  /// one for each range, even if the range goes beyond the request. Returns false if the request
  /// was just answered.
  bool answer(ReaderProxy& proxy, const Receiver& receiver, const SequenceNumberSet& missing,
              MonotonicTime now);
  /// Accepts the request of a NACK_FRAG, which is answered in portions. Returns false if the
  /// request is already being answered, or if the reader has used up its allowance.
  bool begin(ReaderProxy& proxy, const NackFrag& nack, MonotonicTime now);
  /// Sends a portion of the fragments. Returns false if nothing was due.
  bool send_portion(ReaderProxy& proxy, const Receiver& receiver, MonotonicTime now);

 private:
  class Answer;

  const WriterHistory& history_;
  WriterMessages& messages_;
  EvaluationAllowance& evaluations_;
};

}  // namespace ddssec::rtps
