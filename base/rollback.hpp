// Undoes what a function has begun, unless the function reaches its end.
#pragma once

#include <utility>

namespace ddssec {

/// Calls `undo` at the end of its scope unless released. An early return or an exception (any
/// allocation may fail) therefore leaves the state unchanged. `undo` must not throw.
template <class F>
class Rollback {
 public:
  explicit Rollback(F undo) : undo_(std::move(undo)) {}
  ~Rollback() {
    if (is_armed_) undo_();
  }
  Rollback(const Rollback&) = delete;
  Rollback& operator=(const Rollback&) = delete;

  /// Marks the work as complete, so that `undo` is not called.
  void release() { is_armed_ = false; }

 private:
  F undo_;
  bool is_armed_ = true;
};

}  // namespace ddssec
