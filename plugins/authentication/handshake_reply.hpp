// HandshakeReplyMessageToken, "+Reply": the replier's answer, signed (DDS-Security 9.3.2.5.2).
#pragma once

#include "pki/private_key.hpp"
#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// Borrowed from a token. The form is checked; the signature is not.
struct HandshakeReply {
  Credentials credentials;
  BytesView dh2;
  spi::Challenge challenge1{};
  spi::Challenge challenge2{};
  std::optional<Sha256Digest> hash_c1 = {};
  std::optional<Sha256Digest> hash_c2 = {};
  std::optional<BytesView> dh1 = {};
  BytesView signature;

  /// Errors of TokenFields and Credentials::read.
  static Result<HandshakeReply> read(const spi::Token& token);

  /// `sent` completed with the replier's values, if the reply answers it and says nothing else
  /// about it. Error: token_field_differs.
  Result<Transcript> verify(const Transcript& sent) const;

  /// Signs and writes, with all optional fields: Fast DDS insists on them. Error: internal.
  static Result<spi::Token> write(const Credentials& credentials, const Transcript& transcript,
                                  const pki::PrivateKey& key);
};

}  // namespace ddssec::authentication
