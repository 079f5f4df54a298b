#include "plugins/authentication/handshake_request.hpp"

namespace ddssec::authentication {

Result<HandshakeRequest> HandshakeRequest::read(const spi::Token& token) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(token, TokenClass::request));
  DDSSEC_ASSIGN_OR_RETURN(const auto credentials, Credentials::read(fields));
  DDSSEC_ASSIGN_OR_RETURN(const auto dh1, fields.required(kDh1));
  DDSSEC_ASSIGN_OR_RETURN(const auto challenge1, fields.challenge(kChallenge1));
  DDSSEC_ASSIGN_OR_RETURN(const auto hash_c1, fields.optional_hash(kHashC1));
  return HandshakeRequest{
      .credentials = credentials, .dh1 = dh1, .challenge1 = challenge1, .hash_c1 = hash_c1};
}

Result<Transcript> HandshakeRequest::verify() const {
  Transcript transcript{
      .hash_c1 = credentials.hash(), .challenge1 = challenge1, .dh1 = to_bytes(dh1)};
  DDSSEC_RETURN_IF_ERROR(check_repeated(kHashC1, hash_c1, transcript.hash_c1, TokenClass::request));
  return transcript;
}

spi::Token HandshakeRequest::write(const Credentials& credentials, const Transcript& transcript) {
  spi::Token token{std::string(class_id_of(TokenClass::request))};
  credentials.write(token);
  add_field(token, kHashC1, transcript.hash_c1);
  add_field(token, kDh1.name, transcript.dh1);
  add_field(token, kChallenge1, transcript.challenge1);
  return token;
}

}  // namespace ddssec::authentication
