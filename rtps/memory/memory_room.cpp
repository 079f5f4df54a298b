#include "rtps/memory/memory_room.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

namespace ddssec::rtps::memory {
namespace {

// The files in one version of cgroups.
struct Version {
  const char* folder;
  const char* limit;
  const char* slow;  // the limit above which the system slows the processes down; may be empty
  const char* used;
  const char* droppable;  // the line of memory.stat about files that can be dropped
};
constexpr Version kTwo{"/sys/fs/cgroup", "/memory.max", "/memory.high", "/memory.current",
                       "inactive_file"};
constexpr Version kTwoBesideOne{"/sys/fs/cgroup/unified", "/memory.max", "/memory.high",
                                "/memory.current", "inactive_file"};
constexpr Version kOne{"/sys/fs/cgroup/memory", "/memory.limit_in_bytes", "",
                       "/memory.usage_in_bytes", "total_inactive_file"};

std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t out = 0;
  return file >> out ? std::optional(out) : std::nullopt;  // "max" means no limit
}

std::uint64_t droppable_in(const std::string& folder, const char* name) {
  std::ifstream file(folder + "/memory.stat");
  std::string word;
  std::uint64_t out = 0;
  while (file >> word >> out)
    if (word == name) return out;
  return 0;
}

std::optional<std::uint64_t> least(std::optional<std::uint64_t> one,
                                   std::optional<std::uint64_t> other) {
  if (!one || !other) return one ? one : other;
  return std::min(*one, *other);
}

std::optional<std::uint64_t> room_of(const std::string& folder, const Version& version) {
  const auto limit = least(number_in(folder + version.limit), number_in(folder + version.slow));
  const auto used = number_in(folder + version.used);
  if (!limit || !used) return std::nullopt;
  const auto needed = *used - std::min(*used, droppable_in(folder, version.droppable));
  return *limit - std::min(*limit, needed);
}

// In a container the path may be that of the host. Then only the group at the top is found.
std::optional<std::uint64_t> room_along(const std::string& root, std::string path,
                                        const Version& version) {
  std::optional<std::uint64_t> out;
  while (true) {
    out = least(out, room_of(root + version.folder + path, version));
    if (path.empty()) return out;
    path.erase(std::min(path.rfind('/'), path.size()));
  }
}

bool lists_memory(const std::string& controllers) {
  std::istringstream names(controllers);
  for (std::string name; std::getline(names, name, ',');)
    if (name == "memory") return true;
  return false;
}

}  // namespace

// Lines are "number:controllers:path"; the lines of version 2 name no controllers.
std::optional<std::uint64_t> memory_room(const std::string& root) {
  std::optional<std::uint64_t> out;
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const auto controllers = line.substr(first + 1, second - first - 1);
    auto path = line.substr(second + 1);
    if (path == "/") path.clear();
    if (controllers.empty())
      out = least(out, least(room_along(root, path, kTwo), room_along(root, path, kTwoBesideOne)));
    else if (lists_memory(controllers))
      out = least(out, room_along(root, path, kOne));
  }
  return out;
}

bool has_memory_room(std::uint64_t octets, const std::string& root) {
  const auto room = memory_room(root);
  return !room || *room / 2 >= octets;
}

}  // namespace ddssec::rtps::memory
