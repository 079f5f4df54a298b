// A file descriptor that closes itself.
#pragma once

#include <unistd.h>
#include <utility>

namespace ddssec {

/// Owns the descriptor. Movable.
class FileDescriptor {
 public:
  explicit FileDescriptor(int number = -1) : number_(number) {}
  ~FileDescriptor() {
    if (number_ >= 0) ::close(number_);
  }
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    const FileDescriptor former(std::exchange(number_, std::exchange(other.number_, -1)));
    return *this;
  }
  explicit operator bool() const { return number_ >= 0; }
  int number() const { return number_; }
  /// Returns the descriptor without closing it, for a call that closes it.
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

}  // namespace ddssec
