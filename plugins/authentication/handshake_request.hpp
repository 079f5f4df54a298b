// HandshakeRequestMessageToken, "+Req": the initiator's first message (DDS-Security 1.2,
// clause 10.3.2.5.1).
#pragma once

#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/transcript.hpp"

namespace ddssec::authentication {

/// The message, borrowed from a token. Its form is checked; the sender is unproven.
struct HandshakeRequest {
  Credentials credentials;
  BytesView dh1;
  spi::Challenge challenge1{};
  std::optional<Sha256Digest> hash_c1 = {};

  /// Checks the form. Errors: those of TokenFields and Credentials::read.
  static Result<HandshakeRequest> read(const spi::Token& token);

  /// Returns the replier's transcript up to this message. Error: token_field_differs if the message
  /// has a hash_c1 that is not the hash of its credentials.
  Result<Transcript> verify() const;

  /// Writes the message with the optional hash, which Fast DDS requires.
  static spi::Token write(const Credentials& credentials, const Transcript& transcript);
};

}  // namespace ddssec::authentication
