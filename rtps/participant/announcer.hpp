// Announces the local participant by SPDP (RTPS 8.5.3). If it is secured, also announces it by
// DCPSParticipantsSecure to authenticated peers.
#pragma once

#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Sends the announcements of one local participant, when they are due or when a peer asks.
class Announcer {
 public:
  /// The largest number of announcements that are answered at once, in each kAnswerPeriod. The
  /// addresses in them are not proven.
  static constexpr int kMaxAnswers = 100;
  static constexpr MonotonicTime kAnswerPeriod = std::chrono::milliseconds(10);
  /// The shortest time between two announcements to all, if more announcements arrive than can be
  /// answered.
  static constexpr MonotonicTime kMinPeriod = std::chrono::milliseconds(250);
  /// How often announce_soon() begins a burst of announcements, at once and in each kBurstPeriod.
  static constexpr int kMaxBursts = 4;
  static constexpr MonotonicTime kBurstPeriod = std::chrono::seconds(5);

  Announcer(ParticipantCore& core, BuiltinEndpoints& builtin);

  /// Returns the data that SPDP announces of the local participant.
  ParticipantData own_data() const;
  /// Announces the local participant to a participant that was heard for the first time, as far as
  /// AmplificationLimit allows sending to it.
  void answer(const GuidPrefix& participant, std::span<const Locator> metatraffic);
  /// Call it after the announced data changed.
  void announce_again();
  /// Announces from now on as often as in the beginning.
  void announce_often() { announcements_ = 0; }
  /// Announces as soon as kMinPeriod allows, and often after that if kMaxBursts allows. Peers can
  /// cause it.
  void announce_soon();
  /// Sends to authenticated participants the data that must not be sent unprotected, or a dispose
  /// if `leaving`.
  void announce_securely(bool leaving = false);
  /// Disposes the local participant, so that peers know that it leaves.
  void leave(const RemoteParticipants& remotes);
  /// Announces the local participant if an announcement is due.
  void tick();
  MonotonicTime next_tick() const { return next_; }

 private:
  static constexpr MonotonicTime kFastPeriod = std::chrono::milliseconds(100);
  static constexpr MonotonicTime kRepeatDelay = std::chrono::milliseconds(500);

  /// For `charged` see Destination.
  void announce(std::span<const Locator> to, const GuidPrefix& charged = {});
  void announce(const ParticipantData& own, const Destination& to);
  MonotonicTime period() const;

  ParticipantCore& core_;
  BuiltinEndpoints& builtin_;
  WorkBudget answers_{kMaxAnswers, kAnswerPeriod, {}};
  WorkBudget bursts_{kMaxBursts, kBurstPeriod, {}};
  int announcements_ = 0;
  MonotonicTime next_{}, last_{};
};

}  // namespace ddssec::rtps
