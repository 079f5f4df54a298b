// What threads still use while the process exits.
#pragma once

namespace ddssec {

/// OpenSSL frees nothing at exit(). Has no effect if the application has initialized OpenSSL
/// before.
void keep_openssl_at_exit() noexcept;

}  // namespace ddssec
