// AuthRequestMessageToken: the challenge that the sender will use later (DDS-Security 9.3.2.4).
#pragma once

#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

spi::Token write_auth_request(const spi::Challenge& future_challenge);

/// The peer's future_challenge. Errors: token_class_wrong, token_too_large, token_field_missing,
/// token_field_repeated, token_field_length.
Result<spi::Challenge> read_auth_request(const spi::Token& token);

}  // namespace ddssec::authentication
