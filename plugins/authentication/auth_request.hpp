// AuthRequestMessageToken: announces the challenge that the sender will use in the handshake
// (DDS-Security 1.2, clause 10.3.2.4).
#pragma once

#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// Returns the token to send.
spi::Token write_auth_request(const spi::Challenge& future_challenge);

/// Returns the future_challenge in a peer's token. Errors: token_class_wrong, token_too_large,
/// token_field_missing, token_field_repeated, token_field_length.
Result<spi::Challenge> read_auth_request(const spi::Token& token);

}  // namespace ddssec::authentication
