// HandshakeFinalMessageToken, "+Final": the initiator's signature (DDS-Security 1.2,
// clause 10.3.2.5.3).
#pragma once

#include "pki/private_key.hpp"
#include "plugins/authentication/token_fields.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// The message, borrowed from a token. Its form is checked, its signature is not.
struct HandshakeFinal {
  spi::Challenge challenge1{};
  spi::Challenge challenge2{};
  std::optional<Sha256Digest> hash_c1 = {};
  std::optional<Sha256Digest> hash_c2 = {};
  std::optional<BytesView> dh1 = {};
  std::optional<BytesView> dh2 = {};
  BytesView signature;

  /// Checks the form. Errors: those of TokenFields.
  static Result<HandshakeFinal> read(const spi::Token& token);

  /// Success if every value in the message agrees with `transcript`. Error: token_field_differs.
  Status verify(const Transcript& transcript) const;

  /// Signs and writes the message with all optional fields. Error: internal.
  static Result<spi::Token> write(const Transcript& transcript, const pki::PrivateKey& key);
};

}  // namespace ddssec::authentication
