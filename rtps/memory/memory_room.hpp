// The memory that the limits of the process's memory cgroup leave.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ddssec::rtps::memory {

/// Returns the room in octets: the least that a group of the process, or a group above it, leaves.
/// Files that the system can drop are not counted as used. Empty if there is no limit, or if it
/// cannot be seen. `root` is the folder before /proc and /sys, for tests.
std::optional<std::uint64_t> memory_room(const std::string& root = "");
/// True if so much memory can be taken and as much again is left. Above the limit, the system does
/// not refuse but ends a process. True too if there is no limit, or if it cannot be seen. `root` is
/// that of memory_room().
bool has_memory_room(std::uint64_t octets, const std::string& root = "");

}  // namespace ddssec::rtps::memory
