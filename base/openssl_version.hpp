// Which OpenSSL this process runs on.
#pragma once

#include <string>

namespace ddssec {

/// What the library that is loaded says of itself, "OpenSSL 3.0.17 1 Jul 2025". It may be of
/// another patch level than the one we were compiled with.
std::string openssl_version();

}  // namespace ddssec
