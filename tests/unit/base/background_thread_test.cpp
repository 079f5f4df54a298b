#include "base/background_thread.hpp"

#include <csignal>
#include <future>
#include <pthread.h>

#include <gtest/gtest.h>

namespace ddssec {
namespace {

sigset_t mask_of_this_thread() {
  sigset_t mask;
  pthread_sigmask(SIG_SETMASK, nullptr, &mask);
  return mask;
}

template <class Thread>
sigset_t mask_of_a_new() {
  std::promise<sigset_t> mask;
  auto thread = start_background_thread<Thread>([&] { mask.set_value(mask_of_this_thread()); });
  thread.join();
  return mask.get_future().get();
}

TEST(BackgroundThread, Started_BlocksSignalsOfTheProcess) {
  for (const auto& mask : {mask_of_a_new<std::thread>(), mask_of_a_new<std::jthread>()})
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGCHLD,
                             SIGPIPE, SIGPROF, SIGRTMIN, SIGRTMAX})
      EXPECT_EQ(sigismember(&mask, signal), 1) << signal;
}

TEST(BackgroundThread, Started_ItsOwnFaults_StayDeliverable) {
  const auto mask = mask_of_a_new<std::jthread>();
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL})
    EXPECT_EQ(sigismember(&mask, signal), 0) << signal;
}

TEST(BackgroundThread, Started_MaskOfTheCaller_IsAsBefore) {
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, SIGUSR2);
  pthread_sigmask(SIG_BLOCK, &one, nullptr);
  mask_of_a_new<std::jthread>();
  const auto mask = mask_of_this_thread();
  EXPECT_EQ(sigismember(&mask, SIGUSR2), 1);
  EXPECT_EQ(sigismember(&mask, SIGINT), 0);
  pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
}

}  // namespace
}  // namespace ddssec
