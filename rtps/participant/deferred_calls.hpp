// What a listener asks for from within a call, and what is only safe when that call is over.
#pragma once

#include <functional>
#include <utility>
#include <vector>

namespace ddssec::rtps {

class DeferredCalls {
 public:
  /// A call from outside, in which listeners may be called. At the end of the outermost one what
  /// was deferred is done.
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
  /// Now, or when the outermost call is over.
  void after_call(std::function<void()> f) {
    const Scope scope(*this);
    later_.push_back(std::move(f));
  }

 private:
  /// Each of them may add another one.
  void run() {
    while (!later_.empty())
      for (const auto& f : std::exchange(later_, {})) f();
  }

  int depth_ = 0;
  std::vector<std::function<void()>> later_;
};

}  // namespace ddssec::rtps
