// Takes back what a function has begun, unless it gets to its end.
#pragma once

#include <utility>

namespace ddssec {

/// Calls `undo` at the end of its scope unless released: whatever returns early or throws in
/// between (memory may run out anywhere) leaves things as they were. `undo` must not throw.
template <class F>
class Rollback {
 public:
  explicit Rollback(F undo) : undo_(std::move(undo)) {}
  ~Rollback() {
    if (armed_) undo_();
  }
  Rollback(const Rollback&) = delete;
  Rollback& operator=(const Rollback&) = delete;

  /// All is done.
  void release() { armed_ = false; }

 private:
  F undo_;
  bool armed_ = true;
};

}  // namespace ddssec
