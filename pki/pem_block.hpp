// Internal to pki/: blocks of PEM texts, and how octets in DER are told from them.
#pragma once

#include <optional>
#include <string>

#include <openssl/bio.h>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// One block of a PEM text.
struct PemBlock {
  std::string label;
  Bytes der;
};

/// True if the octets begin with a SEQUENCE in DER, as certificates, lists and keys in DER do.
bool is_der(BytesView octets);

/// Reads the next PEM block, and skips text between blocks; nothing at the end. Refuses encrypted
/// blocks (malformed).
Result<std::optional<PemBlock>> next_pem_block(BIO* bio);

}  // namespace ddssec::pki
