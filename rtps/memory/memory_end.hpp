// Notices that memory which this process no longer has is gone from all others, too.
#pragma once

#include <optional>

namespace ddssec::rtps::memory {

/// Memory lasts until no process has a descriptor of it, of whatever kind, or a mapping.
/// Thread-safe.
class MemoryEnd {
 public:
  /// The caller closes the descriptor and its mappings after this. Empty: the system cannot watch
  /// it (no inotify is left).
  static std::optional<MemoryEnd> watch(int descriptor);
  /// True once nothing has the memory any longer; the object has no further use then.
  bool is_over() const;

 private:
  explicit MemoryEnd(int number) : number_(number) {}

  int number_;
};

}  // namespace ddssec::rtps::memory
