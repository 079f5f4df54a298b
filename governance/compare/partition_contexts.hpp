// The sets of partitions that rules tell apart, and which elements each set leaves.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// A publish or subscribe element and its rule.
struct RuleElement {
  const Rule* rule;
  const Criteria* criteria;
};

/// Entities that have these partitions, and which elements of two lists can be met by them, by
/// number, ascending. What is left to decide is the topic.
struct PartitionContext {
  std::vector<std::string> partitions;  ///< never empty; "" is the default partition
  std::vector<std::uint32_t> old_elements = {}, new_elements = {};
};

struct PartitionContexts {
  /// Different from each other in their elements; the default partition first.
  std::vector<PartitionContext> contexts;
  /// False: only one and two partitions at a time were tried, perhaps not all pairs.
  bool is_exact = true;
};

/// Up to this many different kinds of partitions, every set of them is tried.
inline constexpr std::size_t kMostExactPartitions = 10;

/// For entities without data tags. Of all partitions an allow rule must list each one, and a deny
/// rule any (DDS-Security 1.2 9.4.1.3.2.3.1.4); names of partitions are taken literally. Nothing if
/// the expressions have too many combinations.
std::optional<PartitionContexts> partition_contexts(std::span<const RuleElement> old_elements,
                                                    std::span<const RuleElement> new_elements);

}  // namespace ddssec::governance
