// HandshakeFinalMessageToken, "+Final": the initiator's proof (DDS-Security 9.3.2.5.3).
#pragma once

#include "pki/private_key.hpp"
#include "plugins/authentication/token_fields.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// Borrowed from a token. The form is checked; the signature is not.
struct HandshakeFinal {
  spi::Challenge challenge1{};
  spi::Challenge challenge2{};
  std::optional<Sha256Digest> hash_c1 = {};
  std::optional<Sha256Digest> hash_c2 = {};
  std::optional<BytesView> dh1 = {};
  std::optional<BytesView> dh2 = {};
  BytesView signature;

  /// Errors of TokenFields.
  static Result<HandshakeFinal> read(const spi::Token& token);

  /// Success if everything in the message agrees with `transcript`. Error: token_field_differs.
  Status verify(const Transcript& transcript) const;

  /// Signs and writes, with all optional fields. Error: internal.
  static Result<spi::Token> write(const Transcript& transcript, const pki::PrivateKey& key);
};

}  // namespace ddssec::authentication
