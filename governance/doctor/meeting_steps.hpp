// The parts of meet(). For governance/doctor/ only.
#pragma once

#include <memory>

#include "governance/decision.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::governance::doctor {

/// Both parties, by their index.
inline constexpr int kBoth[] = {0, 1};

/// What the steps look at.
struct MeetingScene {
  const Party* parties[2];
  const Settings& settings;
  Meeting& out;
  bool named = false;  ///< the topics were asked for by name: refusals come with advice
  /// Each party's own grant, ready to judge; null if it has none that is valid.
  std::unique_ptr<const CompiledGrant> grants[2] = {};

  const Party& party(int index) const { return *parties[index]; }
  const LoadedFolder& folder(int index) const { return parties[index]->folder; }
};

/// A name to look at, and the documents' expression of which it is an example; empty: of none.
struct TopicOfInterest {
  std::string name;
  std::string expression = {};
};

/// The names to look at if none are asked for; sets topics_complete.
std::vector<TopicOfInterest> topics_of_interest(const MeetingScene& scene);
/// Both directions of one topic; who asked for it by name is told who refuses it.
void meet_on_topic(const MeetingScene& scene, const TopicOfInterest& topic);

/// The elements that must be equal for participants.
std::vector<Difference> differences(const DomainRule& a, const DomainRule& b);
/// The elements that must be equal for endpoints of a topic.
std::vector<Difference> differences(const TopicRule& a, const TopicRule& b);

/// "<rtps_protection_kind> is SIGN at talker (governance.p7s:10) and NONE at listener (...:10)".
std::string sentence(const MeetingScene& scene, const Difference& difference);

}  // namespace ddssec::governance::doctor
