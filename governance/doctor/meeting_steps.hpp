// The parts of predict_meeting(). For governance/doctor/ only.
#pragma once

#include <memory>

#include "governance/decision.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::governance::doctor {

/// Both parties, by their index.
inline constexpr int kBoth[] = {0, 1};

/// The input and output of the steps.
struct MeetingScene {
  const Party* parties[2];
  const Settings& settings;
  Meeting& out;
  bool named = false;  ///< the topics were named by the caller: refusals include advice
  /// Each party's compiled grant; nullptr if it has no valid one.
  std::unique_ptr<const CompiledGrant> grants[2] = {};

  const Party& party(int index) const { return *parties[index]; }
  const LoadedFolder& folder(int index) const { return parties[index]->folder; }
};

/// A name to check, and the expression in the documents of which it is an example; empty if there
/// is none.
struct TopicOfInterest {
  std::string name;
  std::string expression = {};
};

/// Adds a finding about the place that was judged.
void add_finding(const MeetingScene& scene, Rule rule, const PartyDecision& judgement,
                 std::string message, std::string hint = {});

/// Judges whether a party starts on its own, and whether the CA has revoked it without its peers
/// knowing.
void diagnose_start(const MeetingScene& scene, int index);

/// Returns the names to check if none are given; sets topics_complete.
std::vector<TopicOfInterest> topics_of_interest(const MeetingScene& scene);
/// Checks both directions of one topic. If the topic was named by the caller, the result says which
/// party refuses it.
void predict_topic(const MeetingScene& scene, const TopicOfInterest& topic);

/// Returns the differences in elements that must be equal for participants.
std::vector<Difference> differences(const DomainRule& a, const DomainRule& b);
/// Returns the differences in elements that must be equal for endpoints of a topic.
std::vector<Difference> differences(const TopicRule& a, const TopicRule& b);

/// Returns "<rtps_protection_kind> is SIGN at talker (governance.p7s:10) and NONE at listener
/// (...:10)".
std::string sentence(const MeetingScene& scene, const Difference& difference);

}  // namespace ddssec::governance::doctor
