// Limits how much work handshakes cause, before anything is proven.
#pragma once

#include "rtps/budget/source_budget.hpp"
#include "rtps/security/peer_handshake.hpp"

namespace ddssec::rtps {

/// The budgets of one local participant. Each kind of work has one of its own, so that forged
/// messages cannot use up what honest peers need. Each function returns false if the work must not
/// be done now. Not thread-safe.
class HandshakeBudgets {
 public:
  /// Limits for the handshakes that are begun with peers that never sent a handshake message, for
  /// each source of announcements: a burst, then one per period.
  static constexpr int kMaxStarts = 32;
  static constexpr MonotonicTime kStartPeriod = std::chrono::milliseconds(25);
  /// The period for messages that are repeated to peers that never sent one.
  static constexpr MonotonicTime kSilentPeriod = std::chrono::milliseconds(200);
  /// Limits for the handshake messages of all peers that cost public-key work.
  static constexpr int kMaxMessages = 200;
  static constexpr MonotonicTime kMessagePeriod = std::chrono::microseconds(2500);
  /// A peer with no more messages than this has a low rate.
  static constexpr int kLowRateMessages = 12;
  static constexpr MonotonicTime kLowRatePeriod = std::chrono::milliseconds(250);
  /// Limits for peers with a higher rate, or with a refused message. They are counted separately.
  static constexpr MonotonicTime kHighRateRequestPeriod = std::chrono::microseconds(1500);
  static constexpr MonotonicTime kHighRateEchoPeriod = std::chrono::microseconds(1000);
  /// Limits for messages that are repeated because a message was dropped, for all peers.
  static constexpr int kMaxResendRequests = 20;
  static constexpr MonotonicTime kResendRequestPeriod = std::chrono::milliseconds(20);
  /// The period for answers that are repeated from memory, for all peers.
  static constexpr MonotonicTime kRepetitionPeriod = std::chrono::milliseconds(2);

  /// Returns the budget of one peer. The peer has a low rate as long as something of it is left.
  static WorkBudget low_rate() { return {kLowRateMessages, kLowRatePeriod, {}}; }

  /// True if a handshake may begin with a peer that never sent a handshake message, and that
  /// `source` announced.
  bool may_begin(const SourceAddress& source, MonotonicTime now) {
    return starts_.try_spend(source, now);
  }
  /// True if a handshake may begin with a peer that has sent a handshake message.
  bool may_begin_again(MonotonicTime now) { return spoken_starts_.try_spend(now); }
  /// True if a message may be repeated to a peer that never sent one.
  bool may_repeat_unasked(const SourceAddress& source, MonotonicTime now) {
    return silent_.try_spend(source, now);
  }
  /// True if a message that needs this effort may be processed.
  bool may_process(Effort effort, bool is_low_rate, MonotonicTime now) {
    if (effort == Effort::memory) return repetitions_.try_spend(now);
    auto& rates = effort == Effort::echo ? echoes_ : requests_;
    return (is_low_rate ? rates.low : rates.high).try_spend(now);
  }
  /// True if a peer may be asked for a message once more, because there was no budget to process
  /// it.
  bool may_request_resend(MonotonicTime now) { return resend_requests_.try_spend(now); }

 private:
  /// One budget for peers with a low rate, one for the others.
  struct Rates {
    WorkBudget low, high;
  };

  SourceBudget starts_{kMaxStarts, kStartPeriod};
  SourceBudget silent_{kMaxStarts, kSilentPeriod};
  WorkBudget spoken_starts_{kMaxMessages, kMessagePeriod, {}};
  Rates requests_{{kMaxMessages, kMessagePeriod, {}}, {kMaxMessages, kHighRateRequestPeriod, {}}};
  Rates echoes_{{kMaxMessages, kMessagePeriod, {}}, {kMaxMessages, kHighRateEchoPeriod, {}}};
  WorkBudget repetitions_{kMaxMessages, kRepetitionPeriod, {}};
  WorkBudget resend_requests_{kMaxResendRequests, kResendRequestPeriod, {}};
};

}  // namespace ddssec::rtps
