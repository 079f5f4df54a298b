// Keeps libraries usable for threads that still run while the process exits.
#pragma once

namespace ddssec {

/// Keeps OpenSSL from freeing its state at exit(). Has no effect if the application has initialized
/// OpenSSL before.
void keep_openssl_at_exit() noexcept;

}  // namespace ddssec
