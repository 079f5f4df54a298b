// Defers actions that a listener requests from within a call, but that are safe only after that
// call.
#pragma once

#include <functional>
#include <utility>
#include <vector>

namespace ddssec::rtps {

/// Runs the deferred actions when the outermost call ends.
class DeferredCalls {
 public:
  /// A call from outside, in which listeners may be called. The deferred functions run at the end
  /// of the outermost one.
  class Scope {
   public:
    explicit Scope(DeferredCalls& calls) : calls_(calls) { ++calls_.depth_; }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
    ~Scope() {
      if (calls_.depth_ == 1) calls_.run();
      --calls_.depth_;
    }

   private:
    DeferredCalls& calls_;
  };

  Scope enter() { return Scope(*this); }
  /// Runs `f` now, or at the end of the outermost call.
  void after_call(std::function<void()> f) {
    const Scope scope(*this);
    later_.push_back(std::move(f));
  }

 private:
  /// Runs the deferred functions, each of which may defer further ones. If an exception (memory is
  /// short) ends one of them, the others still run: it must not leave the destructor.
  void run() noexcept {
    while (!later_.empty())
      for (const auto& f : std::exchange(later_, {})) try {
          f();
        } catch (...) {
          continue;
        }
  }

  int depth_ = 0;
  std::vector<std::function<void()>> later_;
};

}  // namespace ddssec::rtps
