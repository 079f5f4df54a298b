// A file descriptor that closes itself.
#pragma once

#include <unistd.h>
#include <utility>

namespace ddssec {

/// Owns the descriptor. Movable.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  explicit operator bool() const { return number_ >= 0; }
  int number() const { return number_; }
  /// Gives the number away, for a call that closes it.
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

}  // namespace ddssec
