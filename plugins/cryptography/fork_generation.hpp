// Which process this memory is in: a child of fork() has its parent's keys and counters, and must
// not use a number that its parent uses as well.
#pragma once

#include <atomic>
#include <cstdint>

namespace ddssec::cryptography {

/// Changes in the child of every fork(), clone() without CLONE_VM included. Never 0.
///
/// The number lives in a page that the kernel hands to a child full of zeros (MADV_WIPEONFORK). On
/// a system without that, pthread_atfork's handler writes the zero: it sees fork() only.
class ForkGeneration {
 public:
  enum class Means { kernel_if_possible, handler };

  /// Lives to the end of the process, as its means do.
  explicit ForkGeneration(Means means);
  ForkGeneration(const ForkGeneration&) = delete;
  ForkGeneration& operator=(const ForkGeneration&) = delete;
  /// The one that all keys of the process share.
  static ForkGeneration& of_process();

  /// For the message path: 0 in a child that did not call `current` yet.
  std::uint64_t peek() const noexcept { return place_->load(std::memory_order_relaxed); }
  /// Takes no lock: the thread that forked is the only one in the child, and others' locks may
  /// stay locked there for good.
  std::uint64_t current() noexcept;

 private:
  std::atomic<std::uint64_t>* place_;
  std::atomic<std::uint64_t> last_ = 1;  ///< the highest that this process or a parent had
};

}  // namespace ddssec::cryptography
