// Which participants choose ChaCha20-Poly1305, for which keys, and towards which peers it is
// refused.
#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kChaCha = spi::kChaCha20Poly1305Name;

PropertyList operator+(PropertyList a, const PropertyList& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
PropertyList message_cipher(std::string_view name) {
  return {{"org.ddssec.crypto.message_symmetric_cipher_algorithm", std::string(name)}};
}

EndpointSecurityAttributes builtin(ProtectionKind kind) {
  auto attributes = endpoint_attributes(kind, kNone);
  attributes.is_builtin = true;
  return attributes;
}

// Returns the kind of a participant's own message key.
TransformKind message_kind(TwoSides& two) {
  const auto tokens = two.participant_tokens();
  return read_crypto_token(tokens->front())->kind;
}
// Returns the kind of a writer's first key.
TransformKind writer_kind(TwoSides& two, const EndpointSecurityAttributes& attributes,
                          const PropertyList& properties) {
  const auto e = two.endpoints(attributes, properties);
  const auto tokens = two.writer_tokens(e);
  return read_crypto_token(tokens->front())->kind;
}

TEST(CipherChoice, NameOfAWriter_ChoosesItsCipher) {
  TwoSides two;
  const auto kind = [&](std::string_view name, ProtectionKind protection = kEncrypt) {
    return writer_kind(two, endpoint_attributes(protection, kNone), cipher(name));
  };
  EXPECT_EQ(kind("AUTO"), kAes256Gcm);
  EXPECT_EQ(kind("AES128+GCM"), kAes128Gcm);
  EXPECT_EQ(kind("AES256+GCM"), kAes256Gcm);
  EXPECT_EQ(kind(kChaCha), kChachaPoly1305);
  EXPECT_EQ(kind(kChaCha, kSign), kChachaPoly1305Mac);
  EXPECT_EQ(kind("AES128+GCM", kSign), kAes128Gmac);
}

TEST(CipherChoice, NameOfAParticipant_IsForItsUserEndpoints) {
  TwoSides two(kEncrypt, cipher(kChaCha));
  const auto user = endpoint_attributes(kEncrypt, kNone);
  EXPECT_EQ(message_kind(two), kAes256Gcm);
  EXPECT_EQ(writer_kind(two, user, {}), kChachaPoly1305);
  EXPECT_EQ(writer_kind(two, builtin(kEncrypt), {}), kAes256Gcm);
  EXPECT_EQ(writer_kind(two, user, cipher("AUTO")), kChachaPoly1305);
  EXPECT_EQ(writer_kind(two, user, cipher("AES128+GCM")), kAes128Gcm);
  EXPECT_EQ(writer_kind(two, user, key_size("256")), kAes256Gcm);
}

TEST(CipherChoice, NameOfMessages_IsAPropertyOfItsOwn) {
  TwoSides two(kSign, message_cipher(kChaCha));
  EXPECT_EQ(message_kind(two), kChachaPoly1305Mac);
  EXPECT_EQ(writer_kind(two, builtin(kEncrypt), {}), kChachaPoly1305);
  EXPECT_EQ(writer_kind(two, endpoint_attributes(kEncrypt, kNone), {}), kAes256Gcm);
}

TEST(CipherChoice, TheKeySize_SpeaksOfWhatStaysAes) {
  TwoSides two(kEncrypt, cipher(kChaCha) + key_size("128"));
  EXPECT_EQ(message_kind(two), kAes128Gcm);
  EXPECT_EQ(writer_kind(two, endpoint_attributes(kEncrypt, kNone), {}), kChachaPoly1305);
}

TEST(CipherChoice, UnknownNamesAndContradictions_AreRefused) {
  TwoSides two;
  const auto attributes = endpoint_attributes(kEncrypt, kNone);
  for (const auto& bad :
       {cipher(""), cipher("auto"), cipher("AES256"), cipher("ChaCha20-Poly1305"),
        cipher("AES128+GCM "), cipher("AES128+GCM,AES256+GCM"),
        cipher("AES128+GCM") + key_size("256"), cipher("AES256+GCM") + key_size("128"),
        cipher(kChaCha) + key_size("64")}) {
    EXPECT_EQ(
        code_of(two.a.factory().register_local_datawriter(two.a.participant, bad, attributes)),
        Code::invalid_property);
    EXPECT_EQ(code_of(two.a.factory().register_local_participant({}, {}, bad, {})),
              Code::invalid_property);
  }
  EXPECT_EQ(code_of(two.a.factory().register_local_participant({}, {}, message_cipher("none"), {})),
            Code::invalid_property);
}

TEST(CipherChoice, ChosenCipher_IsAnnounced) {
  TwoSides two(kNone, cipher(kChaCha) + key_size("128"));
  auto& factory = two.a.factory();
  EXPECT_EQ(factory.supported_ciphers(), spi::kAllCiphers);
  EXPECT_EQ(supported_ciphers(AeadChoice::openssl), spi::kAllCiphers);
  EXPECT_EQ(factory.cipher_info(two.a.participant).value(),
            (spi::SymmetricCipherInfo{spi::kAllCiphers, spi::kAes128Bit, spi::kAes256Bit,
                                      spi::kChaCha20Poly1305Bit}));
  EXPECT_EQ(code_of(factory.cipher_info({})), Code::crypto_handle_nil);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kNone), {}, cipher("AES256+GCM"));
  EXPECT_EQ(factory.required_ciphers(e.writer).value(), spi::kChaCha20Poly1305Bit);
  EXPECT_EQ(two.b.factory().required_ciphers(e.reader).value(), spi::kAes256Bit);
  EXPECT_EQ(code_of(factory.required_ciphers(e.reader)), Code::crypto_handle_unknown);
}

// Each message comes out as it went in, whatever the two sides choose.

TEST(ChaCha20Poly1305, EveryLevelAndSize_ComesBack) {
  for (const auto kind : {kSign, kEncrypt, ProtectionKind::sign_with_origin_authentication,
                          ProtectionKind::encrypt_with_origin_authentication}) {
    TwoSides two(kind, cipher(kChaCha, true));
    const auto e = two.endpoints(endpoint_attributes(kind, is_encrypted(kind) ? kEncrypt : kSign));
    for (const std::size_t size : {0u, 4u, 16u, 64u, 252u, 1000u, 65000u}) {
      const auto data = data_submessage(size), ack = data_submessage(size, 0x06);
      EXPECT_EQ(decode_payload(two, e, encode_payload(two, e, data).value()).value(), data);
      EXPECT_EQ(decode_submessage(two, e, encode_submessage(two, e, data).value()).value(), data);
      EXPECT_EQ(decode_reply(two, e, encode_reply(two, e, ack).value()).value(), ack);
      const auto message = rtps_message({data});
      EXPECT_EQ(decode_message(two, encode_message(two, message).value())->size(),
                message.size() + 24);
    }
  }
}

TEST(ChaCha20Poly1305, EachSide_ChoosesForWhatItSends) {
  TwoSides two;
  const auto e =
      two.endpoints(endpoint_attributes(kEncrypt, kEncrypt), cipher(kChaCha), cipher("AES128+GCM"));
  const auto data = data_submessage(40), ack = data_submessage(40, 0x06);
  EXPECT_EQ(decode_submessage(two, e, encode_submessage(two, e, data).value()).value(), data);
  EXPECT_EQ(decode_reply(two, e, encode_reply(two, e, ack).value()).value(), ack);
}

// ---- refusals

// One plugin with a peer that announced `ciphers`.
struct Against {
  explicit Against(spi::CipherMask ciphers, const PropertyList& properties = {},
                   ProtectionKind rtps = kNone, spi::CipherMask allowed = spi::kAllCiphers) {
    auto attributes = participant_attributes(rtps);
    attributes.allowed_ciphers = allowed;
    auto& factory = side.factory();
    const auto made = factory.register_local_participant({1}, {1}, properties, attributes);
    refused_at_creation = code_of(made);
    if (!made) return;
    side.participant = *made;
    const auto remote = factory.register_matched_remote_participant(side.participant, {7}, {7},
                                                                    shared_secret(1, ciphers));
    refused_participant = code_of(remote);
    if (remote) side.remote = *remote;
  }
  Code writer(const EndpointSecurityAttributes& attributes, const PropertyList& properties = {}) {
    const auto local =
        side.factory().register_local_datawriter(side.participant, properties, attributes);
    if (!local) return local.error().code();
    return code_of(side.factory().register_matched_remote_datareader(*local, side.remote,
                                                                     shared_secret(), false));
  }
  Code reader(const EndpointSecurityAttributes& attributes, const PropertyList& properties = {}) {
    const auto local =
        side.factory().register_local_datareader(side.participant, properties, attributes);
    if (!local) return local.error().code();
    return code_of(
        side.factory().register_matched_remote_datawriter(*local, side.remote, shared_secret()));
  }
  Side side;
  Code refused_at_creation{0};
  Code refused_participant{0};
};

TEST(CipherRefusal, PeerThatDoesNotUnderstandAnEndpoint_IsRefused) {
  const auto both = endpoint_attributes(kEncrypt, kEncrypt);
  Against aes(spi::kStandardCiphers, cipher(kChaCha), kEncrypt);
  EXPECT_EQ(aes.refused_participant, Code{0}) << "messages are AES";
  EXPECT_EQ(aes.writer(both), Code::cipher_not_understood_by_peer);
  EXPECT_EQ(aes.reader(both), Code::cipher_not_understood_by_peer);
  EXPECT_EQ(aes.writer(endpoint_attributes(kNone, kSign)), Code::cipher_not_understood_by_peer);
  EXPECT_EQ(aes.reader(endpoint_attributes(kNone, kEncrypt)), Code{0}) << "it sends nothing secret";
  EXPECT_EQ(aes.writer(endpoint_attributes(kNone, kNone)), Code{0});
  EXPECT_EQ(aes.writer(both, cipher("AES256+GCM")), Code{0});
  EXPECT_EQ(aes.writer(builtin(kEncrypt)), Code{0});
  Against able(spi::kAllCiphers, cipher(kChaCha), kEncrypt);
  EXPECT_EQ(able.writer(both), Code{0});
  EXPECT_EQ(able.reader(both), Code{0});
}

TEST(CipherRefusal, PeerThatDoesNotUnderstandMessages_IsRefused) {
  Against aes(spi::kStandardCiphers, message_cipher(kChaCha), kSign);
  EXPECT_EQ(aes.refused_participant, Code::cipher_not_understood_by_peer);
  Against unprotected(spi::kStandardCiphers, message_cipher(kChaCha), kNone);
  EXPECT_EQ(unprotected.refused_participant, Code{0});
  EXPECT_EQ(unprotected.writer(builtin(kEncrypt)), Code::cipher_not_understood_by_peer);
}

TEST(CipherRefusal, CipherThatTheGovernanceDoesNotList_IsRefused) {
  constexpr auto kAes = spi::kStandardCiphers;
  EXPECT_EQ(Against(kAes, cipher(kChaCha), kNone, kAes).refused_at_creation,
            Code::cipher_not_allowed);
  EXPECT_EQ(Against(kAes, message_cipher(kChaCha), kNone, kAes).refused_at_creation,
            Code::cipher_not_allowed);
  Against aes(spi::kAllCiphers, {}, kNone, kAes);
  EXPECT_EQ(aes.refused_at_creation, Code{0});
  EXPECT_EQ(aes.writer(endpoint_attributes(kEncrypt, kNone), cipher(kChaCha)),
            Code::cipher_not_allowed);
  EXPECT_EQ(aes.side.factory().cipher_info(aes.side.participant)->supported, kAes);
}

spi::Token token_of(TransformKind kind) {
  KeyMaterial out{.kind = kind};
  out.salt = MasterSalt::copy_of(Bytes(32, 1)).value();
  out.sender_key_id = KeyId{{0, 0, 0, 1}};
  out.sender_key = MasterKey::copy_of(Bytes(32, 2)).value();
  return crypto_token(out);
}

// Returns the answers of a participant to tokens of that kind, for its messages and for one of its
// readers.
std::pair<Code, Code> codes_of_tokens(TransformKind kind, spi::CipherMask announced,
                                      spi::CipherMask allowed) {
  Against peer(announced, {}, kEncrypt, allowed);
  auto& side = peer.side;
  const auto token = token_of(kind);
  const auto messages = side.exchange().set_remote_participant_crypto_tokens(
      side.participant, side.remote, {&token, 1});
  const auto reader =
      side.factory()
          .register_local_datareader(side.participant, {}, endpoint_attributes(kEncrypt, kEncrypt))
          .value();
  const auto writer =
      side.factory().register_matched_remote_datawriter(reader, side.remote, shared_secret());
  const auto keys =
      side.exchange().set_remote_datawriter_crypto_tokens(reader, *writer, {&token, 1});
  return {code_of(messages), code_of(keys)};
}

TEST(CipherRefusal, KeysThatThePeerDidNotAnnounce_AreRefused) {
  using Codes = std::pair<Code, Code>;
  const Codes good{Code{0}, Code{0}};
  const Codes strange{Code::cipher_not_announced, Code::cipher_not_announced};
  const Codes forbidden{Code::cipher_not_allowed, Code::cipher_not_allowed};
  constexpr auto kAll = spi::kAllCiphers;
  constexpr auto kAes = spi::kStandardCiphers;
  EXPECT_EQ(codes_of_tokens(kChachaPoly1305, kAll, kAll), good);
  EXPECT_EQ(codes_of_tokens(kChachaPoly1305, kAes, kAll), strange);
  EXPECT_EQ(codes_of_tokens(kChachaPoly1305, kAll, kAes), forbidden);
  EXPECT_EQ(codes_of_tokens(kAes256Gcm, kAes, kAes), good);
}

TEST(CipherRefusal, NeighbouringKinds_AreRefused) {
  auto octets = serialize_key_material(read_crypto_token(token_of(kChachaPoly1305)).value());
  for (unsigned kind = 0; kind < 256; ++kind) {
    octets[3] = static_cast<std::uint8_t>(kind);
    const auto known = kind == 3 || kind == 4 || kind == 0x91 || kind == 0x92;
    EXPECT_EQ(parse_key_material(octets).has_value(), known) << kind;
    EXPECT_EQ(traits_of(TransformKind{{0, 0, 0, octets[3]}}).has_value(),
              known || kind == 1 || kind == 2);
    EXPECT_EQ(traits_of(TransformKind{{0, 0, 1, octets[3]}}).has_value(),
              known || kind == 1 || kind == 2);
  }
}

}  // namespace
}  // namespace ddssec::cryptography::testing
