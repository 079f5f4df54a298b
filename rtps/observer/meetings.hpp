// How far each two participants that were observed got, and what keeps them apart.
#pragma once

#include "base/finding.hpp"
#include "rtps/observer/observer.hpp"

namespace ddssec::rtps {

enum class MeetingState : std::uint8_t {
  unsecured,      ///< neither has an identity: nothing to see
  apart,          ///< they do not talk: see the finding
  under_way,      ///< not for long enough to judge
  authenticated,  ///< both sent the other protected submessages after the handshake
};
std::string_view to_string(MeetingState state);

struct Meeting {
  GuidPrefix a, b;
  MeetingState state = MeetingState::under_way;
  MonotonicTime met{};                     ///< when both had been heard
  std::optional<MonotonicTime> took = {};  ///< from then until both had sent keys
  /// What keeps them apart; or, of two that authenticated, what may keep them from each other's
  /// topics.
  std::optional<Finding> finding = {};
};

/// How people know it: by its certificate's subject, its name, or else its GUID prefix.
std::string name_of(const GuidPrefix& prefix, const ObservedParticipant& participant);

/// Who issued its certificate, as far as it said; "" if it did not.
std::string issuer_of(const ObservedParticipant& participant);

/// Every two participants of one domain that announced themselves, at most so many.
inline constexpr std::size_t kMostMeetings = 10'000;
std::vector<Meeting> meetings_of(const Observer& observer);

/// CAP005 if several announced themselves and each in a domain of its own: then no two of them
/// meet.
std::optional<Finding> all_in_different_domains(const Observer& observer);

/// What each does that others could read along.
std::vector<Finding> leaks_of(const Observer& observer);

}  // namespace ddssec::rtps
