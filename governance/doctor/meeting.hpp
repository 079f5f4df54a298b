// Whether two participants would talk: what each makes of the other, step by step.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/protection_kind.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// One of the two.
struct Party {
  const LoadedFolder& folder;
  Vendor vendor = Vendor::ours;
  std::string name;    ///< as sentences call it
  Lineup lineup = {};  ///< the version of its product

  /// "Cyclone DDS 0.10.2".
  std::string product() const { return doctor::name(vendor, lineup); }
};

/// What one party says about one question, and the line that decides.
struct Judgement {
  int judge = 0;  ///< 0 or 1: index of the party
  int about = 0;  ///< the participant that is judged, perhaps the judge itself
  bool ok = false;
  std::string reason = {};    ///< a clause
  std::string document = {};  ///< a path; empty = none
  int line = 0;
  std::string operation = {};   ///< "publish", "subscribe", or empty
  std::string grant = {};       ///< the deciding grant's name
  int rule = 0;                 ///< the deciding rule's number in the grant, from 1; 0 = default
  bool is_allow_rule = false;   ///< that rule is one
  std::string expression = {};  ///< the expression that matched the topic
  std::string hint = {};        ///< what to do, where more can be said than the rule of doctor says
};

/// An element of both governance documents with different values.
struct Difference {
  std::string element;
  std::string values[2];
  int lines[2] = {};
};

/// What products do by themselves that keeps a writer and a reader apart.
struct Obstacle {
  std::string reason = {};  ///< empty = there is none
  Rule rule = Rule::DOC085;
  std::string document = {};
  int line = 0;
  std::string hint = {};  ///< empty = the rule's own
};

/// One writer and one reader of a topic.
struct Direction {
  int writer = 0;  ///< index of the party
  bool ok = false;
  std::vector<Judgement> steps = {};
  std::vector<Difference> differences = {};
  Obstacle obstacle = {};
};

struct TopicMeeting {
  std::string topic;
  /// The documents' expression of which `topic` is only an example; empty: it is a topic's own
  /// name, in the documents or as the caller gave it.
  std::string expression = {};
  Direction directions[2];  ///< by the writer's index
  /// The rules for the topic, if both documents have one.
  const TopicRule* rules[2] = {};
};

/// Who begins the handshake: the lower GUID, whose first 48 bits are those of the subject's hash.
enum class Starter : std::uint8_t { first, second, chance };

/// The whole story.
struct Meeting {
  std::vector<Judgement> start;           ///< does each come up
  std::vector<Judgement> authentication;  ///< certificates, each by the other
  std::vector<Judgement> permissions;     ///< permissions documents, each by the other
  std::vector<Judgement> join;            ///< the domain, each by itself and by the other
  std::vector<Difference> differences;    ///< governance of the domain
  const DomainRule* rules[2] = {};        ///< of the domain, if the documents have one
  std::optional<Starter> starter;         ///< if both certificates can be read
  bool handshake_works = true;            ///< between these two products
  bool discovery_works = true;            ///< between these two versions
  bool properties_fit = true;             ///< judged by who can read them, not by meet()
  std::vector<TopicMeeting> topics;
  bool topics_complete = true;    ///< false: more topics than are looked at
  std::vector<Finding> findings;  ///< what keeps them apart
  std::vector<Finding> notes;     ///< what would with other products

  /// True if they come up, authenticate each other and join: everything before topics.
  bool joined() const;
};

/// The most topics that are looked at when none are named.
inline constexpr std::size_t kMostTopics = 256;

/// Looks at both, in the domain. `topics` empty: the names in both documents, and one example for
/// each other way in which their expressions match, where one of them may do something.
Meeting meet(const Party& a, const Party& b, const Settings& settings,
             const std::vector<std::string>& topics = {});

/// The first 48 bits of the GUID of every participant with this certificate's subject, with any
/// product (DDS-Security 9.3.3).
std::uint64_t guid_start(const pki::Certificate& certificate);

/// Who begins, by the subjects of two certificates (DDS-Security 9.3.3).
Starter starter(const pki::Certificate& a, const pki::Certificate& b);

}  // namespace ddssec::governance::doctor
