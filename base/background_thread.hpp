// Threads that the library starts inside another program's process.
#pragma once

#include <csignal>
#include <thread>
#include <utility>

namespace ddssec {

/// While an object lives, the calling thread blocks every signal that may be meant for the process.
/// A thread that is started meanwhile inherits the mask. Signals for faults of a thread itself
/// (SIGSEGV, SIGBUS, SIGFPE, SIGILL) stay deliverable, so that a host's crash handler still
/// receives them.
class SignalBlock {
 public:
  SignalBlock() noexcept;
  ~SignalBlock();
  SignalBlock(const SignalBlock&) = delete;
  SignalBlock& operator=(const SignalBlock&) = delete;

 private:
  sigset_t former_;
};

/// Starts a std::thread or std::jthread that never handles the process's signals. A host that waits
/// for SIGINT in sigwait, or has a thread for its handlers, receives them as before. Every thread
/// of the library is started with this function. Throws what the thread's constructor throws.
template <class Thread, class F>
Thread start_background_thread(F&& f) {
  const SignalBlock blocked;
  return Thread(std::forward<F>(f));
}

}  // namespace ddssec
