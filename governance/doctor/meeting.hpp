// Predicts whether two participants would communicate, step by step.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/protection_kind.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// One of the two participants.
struct Party {
  const LoadedFolder& folder;
  Product product = Product::ddssec;
  std::string name;    ///< its name in messages
  Lineup lineup = {};  ///< the version of its product

  /// Returns a name such as "Cyclone DDS 0.10.2".
  std::string product_name() const { return doctor::name(product, lineup); }
};

/// The decision of one party on one question, and the deciding line.
struct PartyDecision {
  int judge = 0;  ///< 0 or 1: index of the party
  int about = 0;  ///< index of the judged participant, possibly the judge itself
  bool ok = false;
  std::string reason = {};    ///< a clause
  std::string document = {};  ///< a path; empty = none
  int line = 0;
  std::string operation = {};   ///< "publish", "subscribe", or empty
  std::string grant = {};       ///< the deciding grant's name
  int rule = 0;                 ///< the deciding rule's number in the grant, from 1; 0 = default
  bool is_allow_rule = false;   ///< true if that rule is an allow_rule
  std::string expression = {};  ///< the expression that matched the topic
  std::string hint = {};  ///< what to do, if it is more specific than the hint of the doctor's rule
};

/// An element of both governance documents with different values.
struct Difference {
  std::string element;
  std::string values[2];
  int lines[2] = {};
};

/// A behaviour of a product that prevents a writer and a reader from matching.
struct Obstacle {
  std::string reason = {};  ///< empty = there is none
  Rule rule = Rule::DOC085;
  std::string document = {};
  int line = 0;
  std::string hint = {};  ///< empty = the rule's own
};

/// One writer and one reader of a topic.
struct TopicDirection {
  int writer = 0;  ///< index of the party
  bool ok = false;
  std::vector<PartyDecision> steps = {};
  std::vector<Difference> differences = {};
  Obstacle obstacle = {};
};

/// The judgement whether two participants can exchange samples of one topic.
struct TopicMeeting {
  std::string topic;
  /// The expression in the documents of which `topic` is only an example. Empty if `topic` is the
  /// name of a topic, from the documents or from the caller.
  std::string expression = {};
  TopicDirection directions[2];  ///< one for each writer, by index
  /// The rules for the topic, if both documents have one.
  const TopicRule* rules[2] = {};
};

/// The participant that begins the handshake: the one with the lower GUID. Its first 48 bits come
/// from the hash of the subject.
enum class Starter : std::uint8_t { first, second, chance };

/// The whole prediction.
struct Meeting {
  std::vector<PartyDecision> start;           ///< the start of each participant
  std::vector<PartyDecision> authentication;  ///< certificates, each by the other
  std::vector<PartyDecision> permissions;     ///< permissions documents, each by the other
  std::vector<PartyDecision> join;            ///< the domain, each by itself and by the other
  std::vector<Difference> differences;        ///< governance of the domain
  const DomainRule* rules[2] = {};            ///< rules for the domain, if the documents have one
  std::optional<Starter> starter;             ///< set if both certificates can be read
  bool handshake_works = true;  ///< false if a handshake between these two products fails
  bool discovery_works = true;  ///< false if discovery between these two versions fails
  bool properties_fit = true;   ///< set by the caller that can read them, not by predict_meeting()
  std::vector<TopicMeeting> topics;
  bool topics_complete = true;    ///< false if there are more topics than were checked
  std::vector<Finding> findings;  ///< reasons why they do not communicate
  std::vector<Finding> notes;     ///< reasons that would apply with other products

  /// True if they start, authenticate each other and join: everything before topics.
  bool joined() const;
};

/// The largest number of topics that are checked if none are named.
inline constexpr std::size_t kMaxTopics = 256;

/// Predicts the meeting of both in the domain. If `topics` is empty, it checks the topic names in
/// both documents. It also checks one example for each other way in which their expressions match,
/// if one of the parties has rights there.
Meeting predict_meeting(const Party& a, const Party& b, const Settings& settings,
                        const std::vector<std::string>& topics = {});

/// Returns the first 48 bits of the GUID of every participant with this certificate's subject, with
/// any product (DDS-Security 1.2, clause 10.3.3).
std::uint64_t guid_start(const pki::Certificate& certificate);

/// Returns the participant that begins, by the subjects of two certificates (DDS-Security 1.2,
/// clause 10.3.3).
Starter starter(const pki::Certificate& a, const pki::Certificate& b);

}  // namespace ddssec::governance::doctor
