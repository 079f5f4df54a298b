// Notices that memory that this process has given up is gone from all other processes, too.
#pragma once

#include <optional>

namespace ddssec::rtps::memory {

/// Watches memory, which lasts until no process has a descriptor of it, of any kind, or a mapping.
/// Thread-safe.
class MemoryEnd {
 public:
  /// Begins to watch. The caller closes the descriptor and its mappings after this. Returns empty
  /// if the system cannot watch it (no inotify is left).
  static std::optional<MemoryEnd> watch(int descriptor);
  /// True once no process has the memory any longer. The object has no further use then.
  bool is_over() const;

 private:
  explicit MemoryEnd(int number) : number_(number) {}

  int number_;
};

}  // namespace ddssec::rtps::memory
