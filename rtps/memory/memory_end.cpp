#include "rtps/memory/memory_end.hpp"

#include <array>
#include <cstring>
#include <mutex>
#include <set>
#include <string>
#include <sys/inotify.h>
#include <sys/stat.h>

#include "base/file_descriptor.hpp"

namespace ddssec::rtps::memory {
namespace {

// There is one for the process, because a user may have few (fs.inotify.max_user_instances).
struct Watches {
  std::mutex lock;
  FileDescriptor inotify;
  std::set<int> gone;
};

Watches& watches() {
  static auto* const out = new Watches;
  return *out;
}

// Reads which memory is gone. A watch holds no memory. IN_IGNORED means that the kernel has removed
// the inode.
void read_events(Watches& all) {
  alignas(inotify_event) std::array<char, 4096> octets{};
  while (true) {
    const auto size = ::read(all.inotify.number(), octets.data(), octets.size());
    if (size <= 0) return;
    for (std::size_t at = 0; at + sizeof(inotify_event) <= static_cast<std::size_t>(size);) {
      inotify_event event{};
      std::memcpy(&event, octets.data() + at, sizeof event);
      if ((event.mask & IN_IGNORED) != 0) all.gone.insert(event.wd);
      at += sizeof event + event.len;
    }
  }
}

}  // namespace

std::optional<MemoryEnd> MemoryEnd::watch(int descriptor) {
  auto& all = watches();
  const std::lock_guard held(all.lock);
  if (!all.inotify) all.inotify = FileDescriptor(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  if (!all.inotify) return std::nullopt;
  read_events(all);
  const auto path = "/proc/self/fd/" + std::to_string(descriptor);
  ::fchmod(descriptor, S_IRUSR | S_IWUSR);  // a reader of the same user may have changed the mode
  const int number = ::inotify_add_watch(all.inotify.number(), path.c_str(), IN_DELETE_SELF);
  return number < 0 ? std::nullopt : std::optional(MemoryEnd(number));
}

bool MemoryEnd::is_over() const {
  auto& all = watches();
  const std::lock_guard held(all.lock);
  read_events(all);
  return all.gone.erase(number_) > 0;
}

}  // namespace ddssec::rtps::memory
