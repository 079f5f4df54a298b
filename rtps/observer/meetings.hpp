// Finds out how far each pair of observed participants got in authenticating each other, and what
// prevents it.
#pragma once

#include "base/finding.hpp"
#include "rtps/observer/observer.hpp"

namespace ddssec::rtps {

enum class MeetingState : std::uint8_t {
  unsecured,      ///< neither has an identity: nothing to observe
  apart,          ///< they do not communicate, for the reason in the finding
  under_way,      ///< not observed for long enough to decide
  authenticated,  ///< both sent the other protected submessages after the handshake
};
std::string_view to_string(MeetingState state);

/// How far two participants have come with each other, as seen from outside.
struct ObservedMeeting {
  GuidPrefix a, b;
  MeetingState state = MeetingState::under_way;
  MonotonicTime met{};                     ///< when both had been heard
  std::optional<MonotonicTime> took = {};  ///< time from then until both had sent keys
  /// The obstacle to authentication. For two participants that authenticated, what may prevent each
  /// from discovering the other's topics.
  std::optional<Finding> finding = {};
};

/// Returns a readable name: the subject of its certificate, without escapes that a reader does not
/// need, its entity name, or else its GUID prefix.
std::string name_of(const GuidPrefix& prefix, const ObservedParticipant& participant);

/// Returns the issuer of its certificate, as it announced it, in the same form; "" if it did not.
std::string issuer_of(const ObservedParticipant& participant);

/// Returns every pair of participants of one domain that announced themselves, at most
/// kMaxMeetings.
inline constexpr std::size_t kMaxMeetings = 10'000;
std::vector<ObservedMeeting> meetings_of(const Observer& observer);

/// Returns CAP005 if several participants announced themselves and each is in a domain of its own,
/// so that no two of them can communicate.
std::optional<Finding> all_in_different_domains(const Observer& observer);

/// Returns what each participant sends that others could read.
std::vector<Finding> leaks_of(const Observer& observer);

}  // namespace ddssec::rtps
