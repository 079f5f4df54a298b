// Detects fork(). A child process has its parent's keys and counters, and must not use a number
// that its parent uses too.
#pragma once

#include <atomic>
#include <cstdint>

namespace ddssec::cryptography {

/// A number that changes in the child of every fork(), including clone() without CLONE_VM. It is
/// never 0.
///
/// It lives in a page that the kernel fills with zeros in a child (MADV_WIPEONFORK). On a system
/// without that, a pthread_atfork handler writes the zero; it detects fork() only.
class ForkGeneration {
 public:
  enum class Detection { kernel_if_possible, handler };

  /// The object and its page or handler must live until the process ends.
  explicit ForkGeneration(Detection means);
  ForkGeneration(const ForkGeneration&) = delete;
  ForkGeneration& operator=(const ForkGeneration&) = delete;
  /// Returns the instance that all keys of the process share.
  static ForkGeneration& of_process();

  /// Returns the number for the message path; 0 in a child that has not called `current` yet.
  std::uint64_t peek() const noexcept { return place_->load(std::memory_order_relaxed); }
  /// Returns the present number. It takes no lock: the forking thread is the only one in the child,
  /// and locks of other threads may stay locked there forever.
  std::uint64_t current() noexcept;

 private:
  std::atomic<std::uint64_t>* place_;
  std::atomic<std::uint64_t> last_ = 1;  ///< the highest number of this process or a parent
};

}  // namespace ddssec::cryptography
