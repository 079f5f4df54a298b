// HandshakeRequestMessageToken, "+Req": the initiator's first word (DDS-Security 9.3.2.5.1).
#pragma once

#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// Borrowed from a token. The form is checked; who sent it is not known.
struct HandshakeRequest {
  Credentials credentials;
  BytesView dh1;
  spi::Challenge challenge1{};
  std::optional<Sha256Digest> hash_c1 = {};

  /// Errors of TokenFields and Credentials::read.
  static Result<HandshakeRequest> read(const spi::Token& token);

  /// The replier's transcript so far. Error: token_field_differs if a hash_c1 was sent that is not
  /// the hash of the credentials.
  Result<Transcript> verify() const;

  /// With the optional hash: Fast DDS wants it.
  static spi::Token write(const Credentials& credentials, const Transcript& transcript);
};

}  // namespace ddssec::authentication
