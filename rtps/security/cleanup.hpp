// The end of something that a participant holds, as a value.
#pragma once

#include <functional>
#include <utility>

namespace ddssec::rtps {

/// Calls a function once, in its destructor. Can be moved and stored, so that its owner need not
/// remember the call. For the rest of one function, use Rollback.
class Cleanup {
 public:
  /// Does nothing.
  Cleanup() = default;
  explicit Cleanup(std::function<void()> call) : call_(std::move(call)) {}
  Cleanup(Cleanup&& other) noexcept : call_(std::exchange(other.call_, nullptr)) {}
  Cleanup& operator=(Cleanup&& other) noexcept {
    std::swap(call_, other.call_);
    return *this;
  }
  ~Cleanup() {
    if (call_) call_();
  }

 private:
  std::function<void()> call_;
};

}  // namespace ddssec::rtps
