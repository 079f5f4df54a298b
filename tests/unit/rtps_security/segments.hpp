// The segments of shared memory that this process has mapped as writer and as reader.
#pragma once

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace ddssec::rtps::testing {

/// Returns their lines of /proc/self/maps.
inline std::vector<std::string> mappings() {
  std::vector<std::string> out;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find("/memfd:ddssec") != std::string::npos) out.push_back(line);
  return out;
}

inline bool is_in_memory(BytesView needle) {
  return std::ranges::any_of(mappings(), [&](const std::string& line) {
    const auto begin = std::stoull(line, nullptr, 16);
    const auto end = std::stoull(line.substr(line.find('-') + 1), nullptr, 16);
    const BytesView octets(reinterpret_cast<const std::uint8_t*>(begin), end - begin);
    return !std::ranges::search(octets, needle).empty();
  });
}

}  // namespace ddssec::rtps::testing
