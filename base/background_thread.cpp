#include "base/background_thread.hpp"

#include <pthread.h>

namespace ddssec {

SignalBlock::SignalBlock() noexcept {
  sigset_t blocked;
  sigfillset(&blocked);
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) sigdelset(&blocked, fault);
  pthread_sigmask(SIG_BLOCK, &blocked, &former_);
}

SignalBlock::~SignalBlock() { pthread_sigmask(SIG_SETMASK, &former_, nullptr); }

}  // namespace ddssec
