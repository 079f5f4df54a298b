// The sets of partitions and data tags that rules distinguish, with the elements that can match for
// each.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "governance/compare/name_kinds.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// A publish, subscribe or relay element and its rule.
struct RuleElement {
  const GrantRule* rule;
  const Criteria* criteria;
};

/// Entities with certain partitions and data tags, and the elements of two lists that can match
/// them, by number, ascending. For these entities only the topic is left to decide.
struct EntityContext {
  /// The partitions P for which an entity with the single partition P and without data tags belongs
  /// here, by kind.
  std::vector<NameKinds::Kind> single_partitions = {};
  /// One example; its partitions are never empty, "" is the default one.
  std::vector<std::string> partitions = {};
  std::vector<DataTag> data_tags = {};
  std::vector<std::uint32_t> old_elements = {}, new_elements = {};
};

/// The kinds of endpoints that the rules of two documents can distinguish.
struct EntityContexts {
  NameKinds partitions;
  /// The contexts; no two have the same elements. The default partition without data tags comes
  /// first.
  std::vector<EntityContext> contexts = {};
  /// False if there are more than kMaxContexts, so that not all were found.
  bool is_exact = true;
};

inline constexpr std::size_t kMaxContexts = 2048;

/// Computes the contexts. An allow rule must list each of an entity's partitions and data tags, a
/// deny rule any of them (DDS-Security 1.2, clause 10.4.1.5.3.4). Names of partitions are literal.
/// Empty if the expressions have too many combinations.
std::optional<EntityContexts> entity_contexts(std::span<const RuleElement> old_elements,
                                              std::span<const RuleElement> new_elements,
                                              const SetLimits& limits = {});

}  // namespace ddssec::governance
