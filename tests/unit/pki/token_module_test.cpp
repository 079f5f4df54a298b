// Effects of a token's module inside the process that loads it.
#include <csignal>
#include <cstdlib>
#include <dlfcn.h>

#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

bool handles(int signal) {
  sigset_t blocked;
  pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
  return sigismember(&blocked, signal) == 0;
}

// A host may wait for SIGTERM with sigwait, as ddsperf does. If such a thread took the signal, it
// would kill the host.
TEST(TokenModule, ThreadsThatItStarts_HandleNoSignalsOfTheProcess) {
  void* const module = dlopen(DDSSEC_THREADED_MODULE, RTLD_NOW);
  ASSERT_NE(module, nullptr) << dlerror();
  const auto* const handled = static_cast<const int*>(dlsym(module, "handled_signals"));
  ASSERT_NE(handled, nullptr);
  ASSERT_EQ(setenv("PKCS11_MODULE_PATH", DDSSEC_THREADED_MODULE, 1), 0);
  EXPECT_FALSE(PrivateKey::load("pkcs11:token=robot;object=talker?pin-value=1", "key"));
  EXPECT_EQ(*handled, 0);
  EXPECT_TRUE(handles(SIGINT));
  EXPECT_TRUE(handles(SIGTERM));
}

}  // namespace
}  // namespace ddssec::pki
