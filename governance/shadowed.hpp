// Expressions of a list tried in order that can never be the first to match.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// What earlier expressions leave to one.
struct Shadow {
  /// It is never the first to match.
  bool is_dead = false;
  /// If it is dead: positions of the earlier ones that together match all its names, ascending.
  std::vector<std::uint32_t> by = {};
};

/// One answer for each expression. `covers(a, b)` says whether the expression at `a` stands in the
/// way of the later one at `b` for the same names at all (as rules of other partitions do not);
/// it is asked for some pairs only. What cannot be decided within bounds, or with what is left of
/// the effort, counts as not dead.
std::vector<Shadow> shadows(
    std::span<const std::string_view> expressions, SetEffort& effort,
    const std::function<bool(std::uint32_t a, std::uint32_t b)>& covers = {});

}  // namespace ddssec::governance
