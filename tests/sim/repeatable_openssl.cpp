// OpenSSL deprecates replacing its generator in favour of providers; for a test this is shorter.
#define OPENSSL_SUPPRESS_DEPRECATED

#include "tests/sim/repeatable_openssl.hpp"

#include <openssl/rand.h>

#include "tests/sim/dice.hpp"

namespace ddssec::rtps::sim {
namespace {

Dice dice{0};

int fill(unsigned char* out, int size) {
  for (int i = 0; i < size; ++i) out[i] = dice.octet();
  return 1;
}
int is_ready() { return 1; }

const RAND_METHOD kMethod = {nullptr, fill, nullptr, nullptr, fill, is_ready};

}  // namespace

void make_openssl_repeatable(std::uint64_t seed) {
  static const bool set = RAND_set_rand_method(&kMethod) == 1;
  (void)set;
  dice = Dice(seed).fork("openssl");
}

}  // namespace ddssec::rtps::sim
