// The lock that is held while the listeners of a participant are called, and while entities are
// deleted that listeners may be using.
#pragma once

#include <cstdint>

namespace ddssec::rtps {

/// A recursive lock. A thread that calls a listener holds the lock of that participant, and may
/// wait for the lock of another one. A wait that would never end is refused: the thread that holds
/// the lock then waits for the caller, directly or through further threads.
class CallbackLock {
 public:
  CallbackLock();
  CallbackLock(const CallbackLock&) = delete;
  CallbackLock& operator=(const CallbackLock&) = delete;

  enum class Wait : std::uint8_t {
    none,           ///< takes the lock only if it is free
    while_it_ends,  ///< waits, unless the wait would never end
    /// Like while_it_ends, but if two waits are for each other, the other one is refused first.
    first,
  };
  /// Returns false if the lock was not taken.
  [[nodiscard]] bool acquire(Wait wait);
  void release();

 private:
  using ThreadId = const void*;  ///< the address of an object that each thread has
  struct WaitList;
  struct Waiter;
  static WaitList& waits();
  static const Waiter* waiting(ThreadId thread);
  void take(ThreadId thread);
  bool never_ends(const Waiter& waiting) const;
  bool wait_for(Waiter& waiting);

  ThreadId owner_ = nullptr;
  std::uint32_t depth_ = 0;  ///< how often its owner has acquired it
};

}  // namespace ddssec::rtps
