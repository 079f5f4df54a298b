// Counting in a communication status.
#pragma once

#include <algorithm>
#include <cstdint>

#include "rtps/dcps/status.hpp"

namespace ddssec::rtps {

/// Adds to both counts, which stop at 2^31 - 1.
inline void add_to(CountStatus& status, std::int64_t count = 1) {
  constexpr std::int64_t kMax = 0x7fffffff;
  const auto add = [&](std::int32_t& to) {
    to = static_cast<std::int32_t>(std::min(kMax, to + std::min(count, kMax)));
  };
  add(status.total_count);
  add(status.total_count_change);
}

}  // namespace ddssec::rtps
