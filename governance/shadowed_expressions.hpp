// Finds expressions that can never be the first match in a list that is tried in order.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The result for one expression.
struct ShadowedExpression {
  /// True if it is never the first match.
  bool is_dead = false;
  /// If it is dead: positions of the earlier expressions that together match all its names,
  /// ascending.
  std::vector<std::uint32_t> by = {};
};

/// Returns one result for each expression. `covers(a, b)` tells whether the expression at `a` can
/// take names from the later one at `b` at all (rules for other partitions cannot). It is called
/// for some pairs only. An expression that cannot be decided within the limits, or with the effort
/// left, counts as not dead.
std::vector<ShadowedExpression> shadows(
    std::span<const std::string_view> expressions, SetEffort& effort,
    const std::function<bool(std::uint32_t a, std::uint32_t b)>& covers = {});

}  // namespace ddssec::governance
