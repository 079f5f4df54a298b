#include "plugins/authentication/auth_request.hpp"

#include "plugins/authentication/token_fields.hpp"

namespace ddssec::authentication {

spi::Token write_auth_request(const spi::Challenge& future_challenge) {
  return {.class_id = std::string(class_id_of(TokenClass::auth_request)),
          .binary_properties = {{std::string(kFutureChallenge), to_bytes(future_challenge)}}};
}

Result<spi::Challenge> read_auth_request(const spi::Token& token) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(token, TokenClass::auth_request));
  return fields.challenge(kFutureChallenge);
}

}  // namespace ddssec::authentication
