// The sets of partitions and data tags that rules tell apart, and which elements each leaves.
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
  const Rule* rule;
  const Criteria* criteria;
};

/// Entities with such partitions and data tags, and which elements of two lists can be met by them,
/// by number, ascending. What is left to decide is the topic.
struct EntityContext {
  /// Kinds of partitions that an entity with one of them, and without data tags, has.
  std::vector<NameKinds::Kind> single_partitions = {};
  /// One entity; its partitions are never empty, "" is the default one.
  std::vector<std::string> partitions = {};
  std::vector<DataTag> data_tags = {};
  std::vector<std::uint32_t> old_elements = {}, new_elements = {};
};

struct EntityContexts {
  NameKinds partitions;
  /// Different from each other in their elements; the default partition without data tags first.
  std::vector<EntityContext> contexts = {};
  /// False: there are more than kMostContexts of them, and not all were found.
  bool is_exact = true;
};

inline constexpr std::size_t kMostContexts = 2048;

/// Of an entity's partitions and data tags an allow rule must list each one, and a deny rule any
/// (DDS-Security 1.2 10.4.1.5.3.4); names of partitions are taken literally. Nothing if the
/// expressions have too many combinations.
std::optional<EntityContexts> entity_contexts(std::span<const RuleElement> old_elements,
                                              std::span<const RuleElement> new_elements,
                                              const SetLimits& limits = {});

}  // namespace ddssec::governance
