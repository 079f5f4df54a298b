// HandshakeReplyMessageToken, "+Reply": the replier's signed answer (DDS-Security 1.2,
// clause 10.3.2.5.2).
#pragma once

#include "pki/private_key.hpp"
#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// The message, borrowed from a token. Its form is checked, its signature is not.
struct HandshakeReply {
  Credentials credentials;
  BytesView dh2;
  spi::Challenge challenge1{};
  spi::Challenge challenge2{};
  std::optional<Sha256Digest> hash_c1 = {};
  std::optional<Sha256Digest> hash_c2 = {};
  std::optional<BytesView> dh1 = {};
  BytesView signature;

  /// Checks the form. Errors: those of TokenFields and Credentials::read.
  static Result<HandshakeReply> read(const spi::Token& token);

  /// Completes the transcript `sent` with the replier's values, if the reply belongs to it and
  /// repeats its values unchanged. Error: token_field_differs.
  Result<Transcript> verify(const Transcript& sent) const;

  /// Signs and writes the message with all optional fields, which Fast DDS requires. Error:
  /// internal.
  static Result<spi::Token> write(const Credentials& credentials, const Transcript& transcript,
                                  const pki::PrivateKey& key);
};

}  // namespace ddssec::authentication
