#include "plugins/authentication/handshake_reply.hpp"

#include "pki/signature.hpp"

namespace ddssec::authentication {

Result<HandshakeReply> HandshakeReply::read(const spi::Token& token) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fields, TokenFields::of(token, TokenClass::reply));
  DDSSEC_ASSIGN_OR_RETURN(const auto credentials, Credentials::read(fields));
  DDSSEC_ASSIGN_OR_RETURN(const auto dh2, fields.required(kDh2));
  DDSSEC_ASSIGN_OR_RETURN(const auto challenge1, fields.challenge(kChallenge1));
  DDSSEC_ASSIGN_OR_RETURN(const auto challenge2, fields.challenge(kChallenge2));
  DDSSEC_ASSIGN_OR_RETURN(const auto hash_c1, fields.optional_hash(kHashC1));
  DDSSEC_ASSIGN_OR_RETURN(const auto hash_c2, fields.optional_hash(kHashC2));
  DDSSEC_ASSIGN_OR_RETURN(const auto dh1, fields.optional(kDh1));
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, fields.required(kSignature));
  return HandshakeReply{.credentials = credentials,
                        .dh2 = dh2,
                        .challenge1 = challenge1,
                        .challenge2 = challenge2,
                        .hash_c1 = hash_c1,
                        .hash_c2 = hash_c2,
                        .dh1 = dh1,
                        .signature = signature};
}

Result<Transcript> HandshakeReply::verify(const Transcript& sent) const {
  constexpr auto kReply = TokenClass::reply;
  DDSSEC_RETURN_IF_ERROR(check_repeated(kChallenge1, challenge1, sent.challenge1, kReply));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kDh1.name, dh1, sent.dh1, kReply));
  DDSSEC_RETURN_IF_ERROR(check_repeated(kHashC1, hash_c1, sent.hash_c1, kReply));
  Transcript transcript = sent;
  transcript.hash_c2 = credentials.hash();
  transcript.challenge2 = challenge2;
  transcript.dh2 = to_bytes(dh2);
  DDSSEC_RETURN_IF_ERROR(check_repeated(kHashC2, hash_c2, transcript.hash_c2, kReply));
  return transcript;
}

Result<spi::Token> HandshakeReply::write(const Credentials& credentials,
                                         const Transcript& transcript, const pki::PrivateKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(const Bytes signature, pki::sign(key, transcript.reply_input()));
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
