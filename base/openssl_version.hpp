// The version of OpenSSL in this process.
#pragma once

#include <string>

namespace ddssec {

/// Returns the version text of the loaded library, such as "OpenSSL 3.0.17 1 Jul 2025". Its patch
/// level may differ from that of the headers at compile time.
std::string openssl_version();

}  // namespace ddssec
