#include "plugins/authentication/handshake_reply.hpp"

#include "pki/signature.hpp"

namespace ddssec::authentication {

Result<HandshakeReply> HandshakeReply::read(const spi::Token& token) {
  const auto fields = DDSSEC_TRY(TokenFields::of(token, TokenClass::reply));
  return HandshakeReply{.credentials = DDSSEC_TRY(Credentials::read(fields)),
                        .dh2 = DDSSEC_TRY(fields.required(kDh2)),
                        .challenge1 = DDSSEC_TRY(fields.challenge(kChallenge1)),
                        .challenge2 = DDSSEC_TRY(fields.challenge(kChallenge2)),
                        .hash_c1 = DDSSEC_TRY(fields.optional_hash(kHashC1)),
                        .hash_c2 = DDSSEC_TRY(fields.optional_hash(kHashC2)),
                        .dh1 = DDSSEC_TRY(fields.optional(kDh1)),
                        .signature = DDSSEC_TRY(fields.required(kSignature))};
}

Result<Transcript> HandshakeReply::verify(const Transcript& sent) const {
  constexpr auto kReply = TokenClass::reply;
  DDSSEC_TRY(check_repeated(kChallenge1, challenge1, sent.challenge1, kReply));
  DDSSEC_TRY(check_repeated(kDh1.name, dh1, sent.dh1, kReply));
  DDSSEC_TRY(check_repeated(kHashC1, hash_c1, sent.hash_c1, kReply));
  Transcript transcript = sent;
  transcript.hash_c2 = credentials.hash();
  transcript.challenge2 = challenge2;
  transcript.dh2 = to_bytes(dh2);
  DDSSEC_TRY(check_repeated(kHashC2, hash_c2, transcript.hash_c2, kReply));
  return transcript;
}

Result<spi::Token> HandshakeReply::write(const Credentials& credentials,
                                         const Transcript& transcript, const pki::PrivateKey& key) {
  const Bytes signature = DDSSEC_TRY(pki::sign(key, transcript.reply_input()));
  spi::Token token{std::string(class_id_of(TokenClass::reply))};
  credentials.write(token);
  add_field(token, kHashC2, transcript.hash_c2);
  add_field(token, kDh2.name, transcript.dh2);
  add_field(token, kHashC1, transcript.hash_c1);
  add_field(token, kDh1.name, transcript.dh1);
  add_field(token, kChallenge1, transcript.challenge1);
  add_field(token, kChallenge2, transcript.challenge2);
  add_field(token, kSignature.name, signature);
  return token;
}

}  // namespace ddssec::authentication
