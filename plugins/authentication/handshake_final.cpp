#include "plugins/authentication/handshake_final.hpp"

#include "pki/signature.hpp"
#include "plugins/authentication/credentials.hpp"

namespace ddssec::authentication {

Result<HandshakeFinal> HandshakeFinal::read(const spi::Token& token) {
  const auto fields = DDSSEC_TRY(TokenFields::of(token, TokenClass::final));
  return HandshakeFinal{.challenge1 = DDSSEC_TRY(fields.challenge(kChallenge1)),
                        .challenge2 = DDSSEC_TRY(fields.challenge(kChallenge2)),
                        .hash_c1 = DDSSEC_TRY(fields.optional_hash(kHashC1)),
                        .hash_c2 = DDSSEC_TRY(fields.optional_hash(kHashC2)),
                        .dh1 = DDSSEC_TRY(fields.optional(kDh1)),
                        .dh2 = DDSSEC_TRY(fields.optional(kDh2)),
                        .signature = DDSSEC_TRY(fields.required(kSignature))};
}

Status HandshakeFinal::verify(const Transcript& transcript) const {
  constexpr auto kFinal = TokenClass::final;
  DDSSEC_TRY(check_repeated(kChallenge1, challenge1, transcript.challenge1, kFinal));
  DDSSEC_TRY(check_repeated(kChallenge2, challenge2, transcript.challenge2, kFinal));
  DDSSEC_TRY(check_repeated(kDh1.name, dh1, transcript.dh1, kFinal));
  DDSSEC_TRY(check_repeated(kDh2.name, dh2, transcript.dh2, kFinal));
  DDSSEC_TRY(check_repeated(kHashC1, hash_c1, transcript.hash_c1, kFinal));
  return check_repeated(kHashC2, hash_c2, transcript.hash_c2, kFinal);
}

Result<spi::Token> HandshakeFinal::write(const Transcript& transcript, const pki::PrivateKey& key) {
  const Bytes signature = DDSSEC_TRY(pki::sign(key, transcript.final_input()));
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
