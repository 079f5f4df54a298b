#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {

const AeadBackend* ipsec_mb_backend() { return nullptr; }

}  // namespace ddssec::cryptography
