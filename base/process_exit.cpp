#include "base/process_exit.hpp"

#include <openssl/crypto.h>

namespace ddssec {

void keep_openssl_at_exit() noexcept { OPENSSL_init_crypto(OPENSSL_INIT_NO_ATEXIT, nullptr); }

}  // namespace ddssec
