// How much memory the limits of the process's memory cgroup leave.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ddssec::rtps::memory {

/// In octets: the least that a group of the process, or a group above it, leaves. Files that the
/// system can drop are not counted as used. Empty: there is no limit, or it cannot be seen. `root`:
/// folder before /proc and /sys, for tests.
std::optional<std::uint64_t> memory_room(const std::string& root = "");
/// Whether so much can be taken and as much again is left. Beyond its limit, the system ends a
/// process and does not refuse.
bool has_memory_room(std::uint64_t octets);

}  // namespace ddssec::rtps::memory
