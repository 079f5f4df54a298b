#include "base/openssl_version.hpp"

#include <openssl/crypto.h>

namespace ddssec {

std::string openssl_version() { return OpenSSL_version(OPENSSL_VERSION); }

}  // namespace ddssec
