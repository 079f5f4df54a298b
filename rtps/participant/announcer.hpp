// Announces this participant: by SPDP (RTPS 8.5.3) and, if it is secured, to those that
// authenticated by DCPSParticipantsSecure.
#pragma once

#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

class Announcer {
 public:
  /// Announcements that are answered at once. The addresses in them are not proven.
  static constexpr int kMostAnswers = 100;
  static constexpr MonotonicTime kAnswerPeriod = std::chrono::milliseconds(10);
  /// Between two announcements to all, when there are more announcements to answer.
  static constexpr MonotonicTime kShortestPeriod = std::chrono::milliseconds(250);

  Announcer(ParticipantCore& core, BuiltinEndpoints& builtin);

  /// What SPDP announces of us.
  ParticipantData own_data() const;
  /// Announces us to a participant that was heard for the first time, as far as it may be sent
  /// anything (AmplificationLimit).
  void answer(const GuidPrefix& participant, std::span<const Locator> metatraffic);
  /// After what is announced changed.
  void announce_again();
  /// Tells authenticated participants what must not be sent in the clear, or that we leave.
  void announce_securely(bool leaving = false);
  /// Disposes our participant, by which the others know that it leaves.
  void leave(const RemoteParticipants& remotes);
  /// Announces us if it is time.
  void tick();
  MonotonicTime next_tick() const { return next_; }

 private:
  static constexpr MonotonicTime kFastPeriod = std::chrono::milliseconds(100);
  static constexpr MonotonicTime kRepeatDelay = std::chrono::milliseconds(500);

  /// `charged`: see Destination.
  void announce(std::span<const Locator> to, const GuidPrefix& charged = {});
  void announce(const ParticipantData& own, const Destination& to);
  MonotonicTime period() const;

  ParticipantCore& core_;
  BuiltinEndpoints& builtin_;
  WorkBudget answers_{kMostAnswers, kAnswerPeriod, {}};
  int announcements_ = 0;
  MonotonicTime next_{}, last_{};
};

}  // namespace ddssec::rtps
