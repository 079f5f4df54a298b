#include "plugins/authentication/handshake_final.hpp"

#include "pki/signature.hpp"
#include "plugins/authentication/credentials.hpp"

namespace ddssec::authentication {

Result<HandshakeFinal> HandshakeFinal::read(const spi::Token& token) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(token, TokenClass::final));
  DDSSEC_ASSIGN_OR_RETURN(const auto challenge1, fields.challenge(kChallenge1));
  DDSSEC_ASSIGN_OR_RETURN(const auto challenge2, fields.challenge(kChallenge2));
  DDSSEC_ASSIGN_OR_RETURN(const auto hash_c1, fields.optional_hash(kHashC1));
  DDSSEC_ASSIGN_OR_RETURN(const auto hash_c2, fields.optional_hash(kHashC2));
  DDSSEC_ASSIGN_OR_RETURN(const auto dh1, fields.optional(kDh1));
  DDSSEC_ASSIGN_OR_RETURN(const auto dh2, fields.optional(kDh2));
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, fields.required(kSignature));
  return HandshakeFinal{.challenge1 = challenge1,
                        .challenge2 = challenge2,
                        .hash_c1 = hash_c1,
                        .hash_c2 = hash_c2,
                        .dh1 = dh1,
                        .dh2 = dh2,
                        .signature = signature};
}

Status HandshakeFinal::verify(const Transcript& transcript) const {
  constexpr auto kFinal = TokenClass::final;
  DDSSEC_RETURN_IF_ERROR(check_repeated(kChallenge1, challenge1, transcript.challenge1, kFinal));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kChallenge2, challenge2, transcript.challenge2, kFinal));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kDh1.name, dh1, transcript.dh1, kFinal));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kDh2.name, dh2, transcript.dh2, kFinal));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kHashC1, hash_c1, transcript.hash_c1, kFinal));
  return check_repeated(kHashC2, hash_c2, transcript.hash_c2, kFinal);
}

Result<spi::Token> HandshakeFinal::write(const Transcript& transcript, const pki::PrivateKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(const Bytes signature, pki::sign(key, transcript.final_input()));
  spi::Token token{std::string(class_id_of(TokenClass::final))};
  add_field(token, kHashC1, transcript.hash_c1);
  add_field(token, kHashC2, transcript.hash_c2);
  add_field(token, kDh1.name, transcript.dh1);
  add_field(token, kDh2.name, transcript.dh2);
  add_field(token, kChallenge1, transcript.challenge1);
  add_field(token, kChallenge2, transcript.challenge2);
  add_field(token, kSignature.name, signature);
  return token;
}

}  // namespace ddssec::authentication
