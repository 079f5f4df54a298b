// Counts system calls and locks of the program that links counted_calls, of all its threads.
#pragma once

#include <cstdint>

namespace ddssec::counted_calls {

struct Calls {
  std::int64_t waits;     ///< epoll_pwait2
  std::int64_t receives;  ///< recvmmsg
  std::int64_t sends;     ///< sendmmsg
  std::int64_t timers;    ///< timerfd_settime
  std::int64_t others;    ///< read and write
  std::int64_t locks;     ///< pthread_mutex_lock
  Calls operator-(const Calls& before) const {
    return {waits - before.waits,   receives - before.receives, sends - before.sends,
            timers - before.timers, others - before.others,     locks - before.locks};
  }
};

Calls so_far();
/// Returns how often threads of this process other than the caller have slept so far.
std::int64_t sleeps_of_other_threads();

}  // namespace ddssec::counted_calls
