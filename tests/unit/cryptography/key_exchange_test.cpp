// Key tokens: which are accepted, and which are refused with which code.

#include <gtest/gtest.h>

#include "plugins/cryptography/registry.hpp"
#include "tests/unit/cryptography/sample_key_material.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

Code set_writer(TwoSides& two, const WriterToReader& e, std::vector<spi::Token> tokens) {
  return code_of(two.take_writer(e, tokens));
}

TEST(CryptoTokens, CountClassAndForm_AreChecked) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto good = crypto_token(material(kAes256Gcm));
  EXPECT_EQ(set_writer(two, e, {}), Code::crypto_token_count);
  EXPECT_EQ(set_writer(two, e, {good, good, good}), Code::crypto_token_count);
  EXPECT_EQ(set_writer(two, e, {good, good}), Code::key_material_key_id);
  auto bad = good;
  bad.class_id = "DDS:Crypto:AES-GCM-GMAC";
  EXPECT_EQ(set_writer(two, e, {bad}), Code::crypto_token_class);
  bad = good;
  bad.properties.push_back({"a", "b"});
  EXPECT_EQ(set_writer(two, e, {bad}), Code::crypto_token_form);
  bad = good;
  bad.binary_properties.push_back(good.binary_properties.front());
  EXPECT_EQ(set_writer(two, e, {bad}), Code::crypto_token_form);
  bad = good;
  bad.binary_properties.front().name = "dds.cryp.keymatt";
  EXPECT_EQ(set_writer(two, e, {bad}), Code::crypto_token_form);
  bad.binary_properties.clear();
  EXPECT_EQ(set_writer(two, e, {bad}), Code::crypto_token_form);
  EXPECT_EQ(set_writer(two, e, {good}), Code{0}) << "Fast DDS shares one key";
  EXPECT_EQ(code_of(two.take_participant(std::vector{good, good})), Code::crypto_token_count);
  EXPECT_EQ(code_of(two.take_participant({})), Code::crypto_token_count);
}

TEST(CryptoTokens, ARefusedToken_ChangesNothing) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto encoded = encode_submessage(two, e, data_submessage(16)).value();
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gmac))}),
            Code::key_material_kind_mismatch);
  EXPECT_TRUE(decode_submessage(two, e, encoded));
}

TEST(CryptoTokens, Kinds_MustFitTheGovernance) {
  TwoSides two(kEncrypt);
  const auto signs = two.endpoints(endpoint_attributes(kSign, kNone));
  EXPECT_EQ(set_writer(two, signs, {crypto_token(material(kAes128Gmac))}), Code{0});
  EXPECT_EQ(set_writer(two, signs, {crypto_token(material(kAes128Gcm))}),
            Code::key_material_kind_mismatch);
  EXPECT_EQ(set_writer(two, signs, {crypto_token(KeyMaterial{})}),
            Code::key_material_kind_mismatch);
  const auto both = two.endpoints(endpoint_attributes(kSign, kEncrypt));
  EXPECT_EQ(set_writer(two, both, {crypto_token(material(kAes128Gcm))}),
            Code::key_material_kind_mismatch);
  EXPECT_EQ(
      set_writer(two, both,
                 {crypto_token(material(kAes128Gmac, 1)), crypto_token(material(kAes256Gcm, 2))}),
      Code{0});
  EXPECT_EQ(
      set_writer(two, both,
                 {crypto_token(material(kAes256Gcm, 2)), crypto_token(material(kAes128Gmac, 1))}),
      Code::key_material_kind_mismatch);
  const auto set_participant = [&](const KeyMaterial& m) {
    const auto token = crypto_token(m);
    return code_of(two.take_participant({&token, 1}));
  };
  EXPECT_EQ(set_participant(material(kAes256Gmac)), Code::key_material_kind_mismatch);
  EXPECT_EQ(set_participant(KeyMaterial{}), Code::key_material_kind_mismatch);
  EXPECT_EQ(set_participant(material(kAes128Gcm)), Code{0}) << "the size is the sender's choice";
}

TEST(CryptoTokens, OriginAuthentication_NeedsAReceiverKey) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncryptOrigin, kNone));
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gcm))}),
            Code::receiver_specific_key_missing);
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gcm, 1, true))}), Code{0});
}

TEST(CryptoTokens, TokensOnUnprotectedLevels_AreTolerated) {
  // If RTPS messages are not protected, Fast DDS sends a GMAC key, and Cyclone DDS sends none.
  TwoSides two;
  for (const auto& m : {material(kAes256Gmac), KeyMaterial{}}) {
    const auto token = crypto_token(m);
    EXPECT_TRUE(two.take_participant({&token, 1}));
  }
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  const auto token = crypto_token(material(kAes256Gmac));
  EXPECT_TRUE(two.take_reader(e, {&token, 1}));
}

TEST(CryptoTokens, EachProtection_MakesTheTokensThatPeersExpect) {
  TwoSides two;
  const auto count = [&](ProtectionKind submessage, ProtectionKind payload) {
    const auto e = two.endpoints(endpoint_attributes(submessage, payload));
    return std::pair(two.writer_tokens(e)->size(), two.reader_tokens(e)->size());
  };
  EXPECT_EQ(count(kNone, kNone), std::pair(0ul, 0ul));
  EXPECT_EQ(count(kSign, kNone), std::pair(1ul, 1ul));
  EXPECT_EQ(count(kNone, kEncrypt), std::pair(1ul, 1ul)) << "Fast DDS waits for a reader's token";
  EXPECT_EQ(count(kEncrypt, kEncrypt), std::pair(2ul, 1ul));
  const auto e = two.endpoints(endpoint_attributes(kEncryptOrigin, kSign));
  const auto tokens = two.writer_tokens(e).value();
  const auto first = read_crypto_token(tokens[0]).value(),
             second = read_crypto_token(tokens[1]).value();
  EXPECT_EQ(first.kind, kAes256Gcm) << "the submessage's comes first";
  EXPECT_TRUE(first.has_receiver_key());
  EXPECT_EQ(second.kind, kAes256Gmac);
  EXPECT_FALSE(second.has_receiver_key());
  EXPECT_NE(first.sender_key_id, second.sender_key_id);
  const auto participant = two.participant_tokens();
  ASSERT_EQ(participant->size(), 1u);
  EXPECT_EQ(to_hex(participant->front().binary_properties.front().value), to_hex(Bytes(24)));
}

TEST(CryptoTokens, VolatileAndUnprotectedEndpoints_HaveNone) {
  TwoSides two;
  const auto token = crypto_token(material(kAes256Gcm));
  const auto e = two.volatile_endpoints();
  EXPECT_TRUE(two.writer_tokens(e)->empty());
  EXPECT_EQ(set_writer(two, e, {token}), Code::crypto_tokens_not_expected);
  const auto open = two.endpoints(endpoint_attributes(kNone, kNone));
  EXPECT_EQ(set_writer(two, open, {token}), Code::crypto_tokens_not_expected);
}

TEST(Tokens, TokensThatComeAgain_ReplaceTheKeys) {
  TwoSides two(kEncrypt);
  auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto encoded = encode_submessage(two, e, data_submessage(8)).value();
  two.exchange_participant_tokens();
  for (int i = 0; i < 3; ++i) {
    const auto tokens = two.writer_tokens(e).value();
    ASSERT_TRUE(two.take_writer(e, tokens));
    EXPECT_TRUE(decode_submessage(two, e, encoded));
  }
  const auto other = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto others = two.writer_tokens(other).value();
  ASSERT_TRUE(two.take_writer(e, others));
  EXPECT_EQ(code_of(decode_submessage(two, e, encoded)), Code::transform_key_id_mismatch);
}

TEST(Tokens, TokensOfTheSameKeys_HaveTheSameDigest) {
  for (const auto kind : {kEncrypt, kEncryptOrigin}) {
    TwoSides two;
    const auto e = two.endpoints(endpoint_attributes(kind, kEncrypt));
    const auto& exchange = two.b.exchange();
    const auto first = two.writer_tokens(e).value();
    encode_submessage(two, e, data_submessage(8)).value();
    const auto again = two.writer_tokens(e).value();
    EXPECT_NE(first, again) << "they say where the writer is";
    EXPECT_EQ(exchange.digest_of(first), exchange.digest_of(again));
    const auto other = two.endpoints(endpoint_attributes(kind, kEncrypt));
    EXPECT_NE(exchange.digest_of(first), exchange.digest_of(two.writer_tokens(other).value()));
  }
}

}  // namespace
}  // namespace ddssec::cryptography::testing
