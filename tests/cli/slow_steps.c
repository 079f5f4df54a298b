// Preloaded by many_folders_test.py. The steady clock goes on by three seconds at each call, so
// that each step of a command seems to take long.
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

__attribute__((visibility("default"))) int clock_gettime(clockid_t clock, struct timespec* now) {
  static time_t passed = 0;
  const int result = (int)syscall(SYS_clock_gettime, clock, now);
  if (clock == CLOCK_MONOTONIC) now->tv_sec += passed += 3;
  return result;
}
