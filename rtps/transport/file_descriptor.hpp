// Owns a file descriptor of the operating system.
#pragma once

#include <utility>

namespace ddssec::rtps {

/// Closes the descriptor in its destructor.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int value() const { return fd_; }

 private:
  int fd_;
};

}  // namespace ddssec::rtps
