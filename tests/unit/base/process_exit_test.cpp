// A program of its own: OpenSSL must not have been initialized before.
#include "base/process_exit.hpp"

#include <cstdlib>
#include <unistd.h>

#include <gtest/gtest.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

namespace ddssec {
namespace {

constexpr int kUsable = 10, kFreed = 11;

// Handlers of exit() run in reverse order, so this one runs after the one that OpenSSL registers
// when it is first used. After that, OpenSSL refuses to be initialized.
void report_openssl() { ::_exit(OPENSSL_init_crypto(0, nullptr) == 1 ? kUsable : kFreed); }

void exit_after_use(bool keeps) {
  std::atexit(report_openssl);
  if (keeps) keep_openssl_at_exit();
  std::uint8_t octet = 0;
  if (RAND_bytes(&octet, 1) != 1) ::_exit(1);
  std::exit(0);
}

struct ProcessExitDeathTest : ::testing::Test {
  // Starts the program again for each death test: a fork could have OpenSSL's state of another.
  ProcessExitDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(ProcessExitDeathTest, KeptOpenssl_IsUsableWhileTheProcessExits) {
  EXPECT_EXIT(exit_after_use(true), ::testing::ExitedWithCode(kUsable), "");
}

// Otherwise the test above would show nothing.
TEST_F(ProcessExitDeathTest, Openssl_IsFreedWithoutIt) {
  EXPECT_EXIT(exit_after_use(false), ::testing::ExitedWithCode(kFreed), "");
}

}  // namespace
}  // namespace ddssec
