// Compiles documents for decisions in microseconds, with the rule that decided.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/decision_cache.hpp"
#include "governance/model.hpp"
#include "governance/partition_match.hpp"
#include "governance/pattern.hpp"
#include "governance/pattern_set.hpp"

namespace ddssec::governance {

enum class Action : std::uint8_t { publish, subscribe, relay };
/// Returns "domain 0", or "domain 0 with the tag "line 3"".
std::string describe_domain(DomainId domain, std::string_view tag);
/// Returns "publish", "subscribe" or "relay".
std::string_view to_string(Action action);

/// The request of an entity. No partition means the partition "".
struct Request {
  std::string_view topic;
  std::span<const std::string_view> partitions = {};
  std::span<const DataTag> data_tags = {};
};

class RequestedPartition;

/// A decision and the rule that decided. The pointers are valid as long as the CompiledGrant.
struct Decision {
  bool allowed = false;
  /// The deciding rule; nullptr if the grant's default decided.
  const GrantRule* rule = nullptr;
  /// The deciding publish, subscribe or relay element of the rule, if there is one.
  const Criteria* criteria = nullptr;

  /// Returns the line that decided.
  int line(const Grant& grant) const {
    return criteria ? criteria->line : rule ? rule->line : grant.line_of_default();
  }
};

/// True if a rule decides which participants may join its domains. An allow rule admits them; a
/// deny rule without publish and subscribe refuses them (DDS-Security 1.2 table 70). A deny rule
/// about topics does not decide: sros2 writes such rules first.
bool decides_joining(const GrantRule& rule);

/// One grant, compiled for one domain and domain tag. Immutable and thread-safe.
///
/// A rule without domain tags is for the empty tag only (DDS-Security 1.2, clause 10.4.1.2.5.1).
/// Rules are tried in document order. The first that matches decides, otherwise the default. A rule
/// matches if domain, topic, partitions and data tags all match one of its elements.
///
/// - Partitions: an allow rule must list all of the entity's partitions (or one, see
///   PartitionMatch), a deny rule any of them. Data tags: an allow rule must list all of the
///   entity's tags, a deny rule any.
/// - A topic name is always literal. A requested partition with wildcards or a backslash stands for
///   many names. An allow rule must cover all of them: by the same text, by `*`, or by a prefix
///   followed by `*`. A deny rule applies unless the two clearly have no name in common.
class CompiledGrant {
 public:
  CompiledGrant(std::shared_ptr<const Permissions> permissions, const Grant& grant, DomainId domain,
                PartitionMatch partition_match = PartitionMatch::all, std::string_view tag = {});

  const Grant& grant() const { return grant_; }

  Decision judge(Action action, const Request& request) const;
  /// Decides whether the topic may be used with at least some partitions and data tags.
  Decision judge_topic(Action action, std::string_view topic) const;
  /// Decides whether the participant may join: by the first rule for the domain for which
  /// decides_joining is true, otherwise by the default.
  Decision judge_participant() const { return participant_; }
  /// Returns the elements of allow rules for the action, in document order.
  std::vector<const Criteria*> allowed(Action action) const;

 private:
  struct Entry {
    const GrantRule* rule;
    const Criteria* criteria;
    std::vector<std::uint32_t> partitions;  ///< indices into partition_patterns_
  };
  struct ActionIndex {
    std::vector<Entry> entries;  ///< in document order
    PatternSet topics;
    std::vector<std::vector<std::uint32_t>> entries_of_topic;
  };

  void add_rule(const GrantRule& rule);
  void add_entries(Action action, const GrantRule& rule, const std::vector<Criteria>& list);
  std::uint32_t partition_pattern(const std::string& text);
  Decision participant_decision(DomainId domain, std::string_view tag) const;
  template <class Fits>
  Decision first_fitting(const ActionIndex& index, std::string_view topic, Fits&& fits) const;
  bool partitions_fit(const Entry& entry, std::span<RequestedPartition> requested) const;

  std::shared_ptr<const Permissions> permissions_;
  const Grant& grant_;
  PartitionMatch partition_match_;
  std::array<ActionIndex, 3> actions_;
  std::vector<Pattern> partition_patterns_;
  std::unordered_map<std::string, std::uint32_t> partition_numbers_;
  Decision participant_;
  mutable DecisionCache<Decision> seen_;
};

/// The rule of a governance document for one domain, compiled. Thread-safe.
class CompiledGovernance {
 public:
  /// Compiles the rule for the domain and tag. Error: domain_not_covered.
  static Result<std::shared_ptr<const CompiledGovernance>> make(
      std::shared_ptr<const Governance> governance, DomainId domain, std::string_view tag = {});

  const DomainRule& domain_rule() const { return rule_; }
  /// Returns the document's revision, or 0 if it has none.
  std::uint32_t revision() const { return governance_->revision; }
  /// Returns the first topic rule whose expression matches, or nullptr.
  const TopicRule* topic_rule(std::string_view topic) const;

  CompiledGovernance(std::shared_ptr<const Governance> governance, const DomainRule& rule);

 private:
  std::shared_ptr<const Governance> governance_;
  const DomainRule& rule_;
  PatternSet topics_;
  std::vector<const TopicRule*> rule_of_topic_;
  mutable DecisionCache<const TopicRule*> seen_;
};

}  // namespace ddssec::governance
