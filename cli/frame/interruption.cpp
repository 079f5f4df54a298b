#include "cli/frame/interruption.hpp"

#include <atomic>
#include <csignal>
#include <sys/time.h>
#include <utility>

namespace ddssec::cli {
namespace {

volatile std::sig_atomic_t interrupted_by = 0;
std::atomic<int> unfinished = 0;  // the number of living InterruptionGuard objects
static_assert(std::atomic<int>::is_always_lock_free);
constexpr itimerval kTimeToNotice = {.it_interval = {}, .it_value = {0, 200'000}};

// setitimer is only a system call on Linux, so a signal handler may call it.
void await_notice() { ::setitimer(ITIMER_REAL, &kTimeToNotice, nullptr); }

void remember(int signal) {
  await_notice();
  interrupted_by = signal;
}

// A command that only computes does not check for interruptions. A command that writes checks at
// each file, and then removes its drafts.
void end_unless_writing(int) {
  if (unfinished != 0) return await_notice();
  ::signal(interrupted_by, SIG_DFL);
  ::raise(interrupted_by);
}

}  // namespace

Status check_not_interrupted() {
  if (interrupted_by == 0) return {};
  constexpr itimerval kNever = {};
  ::setitimer(ITIMER_REAL, &kNever, nullptr);  // the command ends by itself
  return fail(Code::interrupted);
}

void note_interruptions() {
  struct sigaction action {};
  action.sa_handler = remember;  // without SA_RESTART a prompt for a passphrase ends as well
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(signal, &action, nullptr);
  action.sa_handler = end_unless_writing;
  ::sigaction(SIGALRM, &action, nullptr);
}

InterruptionGuard::InterruptionGuard() { ++unfinished; }

InterruptionGuard::~InterruptionGuard() {
  if (is_counted_) --unfinished;
}

InterruptionGuard::InterruptionGuard(InterruptionGuard&& other) noexcept
    : is_counted_(std::exchange(other.is_counted_, false)) {}

}  // namespace ddssec::cli
