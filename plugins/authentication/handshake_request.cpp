#include "plugins/authentication/handshake_request.hpp"

namespace ddssec::authentication {

Result<HandshakeRequest> HandshakeRequest::read(const spi::Token& token) {
  const auto fields = DDSSEC_TRY(TokenFields::of(token, TokenClass::request));
  return HandshakeRequest{.credentials = DDSSEC_TRY(Credentials::read(fields)),
                          .dh1 = DDSSEC_TRY(fields.required(kDh1)),
                          .challenge1 = DDSSEC_TRY(fields.challenge(kChallenge1)),
                          .hash_c1 = DDSSEC_TRY(fields.optional_hash(kHashC1))};
}

Result<Transcript> HandshakeRequest::verify() const {
  Transcript transcript{
      .hash_c1 = credentials.hash(), .challenge1 = challenge1, .dh1 = to_bytes(dh1)};
  DDSSEC_TRY(check_repeated(kHashC1, hash_c1, transcript.hash_c1, TokenClass::request));
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
