// Each refusal of handles, tokens and properties, with its own code.
#include <gtest/gtest.h>

#include "tests/unit/cryptography/sample_key_material.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

// Handles

TEST(CryptoHandles, NilStaleForeignAndWrongKindAreRefused) {
  TwoSides two(kEncrypt), other(kEncrypt);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  Bytes out(200);
  auto& transform = two.a.transform();
  const auto encode = [&](std::int64_t handle) {
    return code_of(transform.encode_serialized_payload({handle}, Bytes(8), out));
  };
  EXPECT_EQ(encode(0), Code::crypto_handle_nil);
  EXPECT_EQ(encode(-1), Code::crypto_handle_unknown);
  EXPECT_EQ(encode(12345), Code::crypto_handle_unknown);
  EXPECT_EQ(encode(INT64_MAX), Code::crypto_handle_unknown);
  EXPECT_EQ(encode(e.remote_reader.value), Code::crypto_handle_wrong_kind);
  EXPECT_EQ(encode(two.a.participant.value), Code::crypto_handle_wrong_kind);
  const auto foreign = other.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  EXPECT_EQ(encode(foreign.writer.value), Code::crypto_handle_unknown);
  ASSERT_TRUE(two.a.factory().unregister_datawriter(e.writer));
  EXPECT_EQ(encode(e.writer.value), Code::crypto_handle_unknown);
}

TEST(CryptoHandles, AReturnedPlaceGetsANewHandle) {
  TwoSides two(kEncrypt);
  const auto attributes = endpoint_attributes(kEncrypt, kNone);
  auto& factory = two.a.factory();
  const auto first = factory.register_local_datawriter(two.a.participant, {}, attributes).value();
  ASSERT_TRUE(factory.unregister_datawriter(first));
  const auto second = factory.register_local_datawriter(two.a.participant, {}, attributes).value();
  EXPECT_NE(first, second);
  EXPECT_EQ(code_of(factory.unregister_datawriter(first)), Code::crypto_handle_unknown);
  EXPECT_TRUE(factory.unregister_datawriter(second));
}

TEST(CryptoHandles, EveryFunctionRefusesNil) {
  TwoSides two(kEncrypt);
  auto& f = two.a.factory();
  auto& x = two.a.exchange();
  const auto nil = Code::crypto_handle_nil;
  EXPECT_EQ(code_of(f.register_matched_remote_participant({}, {3}, {}, shared_secret())), nil);
  EXPECT_EQ(
      code_of(f.register_matched_remote_participant(two.a.participant, {}, {}, shared_secret())),
      nil);
  EXPECT_EQ(code_of(f.register_local_datawriter({}, {}, {})), nil);
  EXPECT_EQ(code_of(f.register_local_datareader({}, {}, {})), nil);
  EXPECT_EQ(code_of(f.register_matched_remote_datareader({}, two.a.remote, shared_secret(), false)),
            nil);
  EXPECT_EQ(code_of(f.register_matched_remote_datawriter({}, two.a.remote, shared_secret())), nil);
  EXPECT_EQ(code_of(f.unregister_participant({})), nil);
  EXPECT_EQ(code_of(f.unregister_datawriter({})), nil);
  EXPECT_EQ(code_of(f.unregister_datareader({})), nil);
  EXPECT_EQ(code_of(x.create_local_participant_crypto_tokens({}, two.a.remote)), nil);
  EXPECT_EQ(code_of(x.set_remote_participant_crypto_tokens(two.a.participant, {}, {})), nil);
  EXPECT_EQ(code_of(x.create_local_datawriter_crypto_tokens({}, {})), nil);
  EXPECT_EQ(code_of(x.set_remote_datawriter_crypto_tokens({}, {}, {})), nil);
  EXPECT_EQ(code_of(x.create_local_datareader_crypto_tokens({}, {})), nil);
  EXPECT_EQ(code_of(x.set_remote_datareader_crypto_tokens({}, {}, {})), nil);
  Bytes out(300);
  auto& t = two.a.transform();
  EXPECT_EQ(code_of(t.encode_datawriter_submessage({}, {}, data_submessage(8), out)), nil);
  EXPECT_EQ(code_of(t.encode_datareader_submessage({}, {}, data_submessage(8), out)), nil);
  EXPECT_EQ(code_of(t.encode_rtps_message({}, {}, rtps_message({}), out)), nil);
  EXPECT_EQ(code_of(t.decode_rtps_message({}, two.a.remote, {}, out)), nil);
  EXPECT_EQ(code_of(t.preprocess_secure_submessage({}, {}, {})), nil);
  EXPECT_EQ(code_of(t.decode_datawriter_submessage({}, {}, {}, out)), nil);
  EXPECT_EQ(code_of(t.decode_datareader_submessage({}, {}, {}, out)), nil);
  EXPECT_EQ(code_of(t.decode_serialized_payload({}, {}, {}, out)), nil);
}

TEST(CryptoHandles, UnmatchedPairsAreRefused) {
  TwoSides two(kEncryptOrigin);
  const auto attributes = endpoint_attributes(kEncryptOrigin, kEncrypt);
  const auto one = two.endpoints(attributes), other = two.endpoints(attributes);
  EXPECT_EQ(code_of(two.a.exchange().create_local_datawriter_crypto_tokens(one.writer,
                                                                           other.remote_reader)),
            Code::crypto_not_matched);
  Bytes out(400);
  EXPECT_EQ(code_of(two.a.transform().encode_datawriter_submessage(
                one.writer, {&other.remote_reader, 1}, data_submessage(8), out)),
            Code::crypto_not_matched);
  EXPECT_EQ(code_of(two.b.transform().decode_datawriter_submessage(one.reader, other.remote_writer,
                                                                   Bytes(80), out)),
            Code::crypto_not_matched);
  EXPECT_EQ(code_of(two.b.transform().decode_serialized_payload(one.reader, other.remote_writer,
                                                                Bytes(80), out)),
            Code::crypto_not_matched);
  const auto stranger = two.a.factory().register_local_participant(
      {}, {}, {}, participant_attributes(kEncryptOrigin));
  EXPECT_EQ(
      code_of(two.a.exchange().create_local_participant_crypto_tokens(*stranger, two.a.remote)),
      Code::crypto_not_matched);
  EXPECT_EQ(code_of(two.a.transform().encode_rtps_message(*stranger, {&two.a.remote, 1},
                                                          rtps_message({data_submessage(8)}), out)),
            Code::crypto_not_matched);
  const auto writer = two.a.factory().register_local_datawriter(*stranger, {}, attributes).value();
  EXPECT_EQ(code_of(two.a.factory().register_matched_remote_datareader(writer, two.a.remote,
                                                                       shared_secret(), false)),
            Code::crypto_not_matched);
}

// Tokens

Code set_writer(TwoSides& two, const WriterToReader& e, std::vector<spi::Token> tokens) {
  return code_of(two.take_writer(e, tokens));
}

TEST(CryptoTokens, CountClassAndFormAreChecked) {
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

TEST(CryptoTokens, ARefusedTokenChangesNothing) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto encoded = encode_submessage(two, e, data_submessage(16)).value();
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gmac))}),
            Code::key_material_kind_mismatch);
  EXPECT_TRUE(decode_submessage(two, e, encoded));
}

TEST(CryptoTokens, KindsMustFitTheGovernance) {
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

TEST(CryptoTokens, OriginAuthenticationNeedsAReceiverKey) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncryptOrigin, kNone));
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gcm))}),
            Code::receiver_specific_key_missing);
  EXPECT_EQ(set_writer(two, e, {crypto_token(material(kAes256Gcm, 1, true))}), Code{0});
}

TEST(CryptoTokens, WhatPeersSendOnUnprotectedLevelsIsTolerated) {
  TwoSides two;  // RTPS messages unprotected: Fast DDS sends a GMAC key, Cyclone DDS none
  for (const auto& m : {material(kAes256Gmac), KeyMaterial{}}) {
    const auto token = crypto_token(m);
    EXPECT_TRUE(two.take_participant({&token, 1}));
  }
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  const auto token = crypto_token(material(kAes256Gmac));
  EXPECT_TRUE(two.take_reader(e, {&token, 1}));
}

TEST(CryptoTokens, AreWhatPeersExpect) {
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

TEST(CryptoTokens, VolatileAndUnprotectedEndpointsHaveNone) {
  TwoSides two;
  const auto token = crypto_token(material(kAes256Gcm));
  const auto e = two.volatile_endpoints();
  EXPECT_TRUE(two.writer_tokens(e)->empty());
  EXPECT_EQ(set_writer(two, e, {token}), Code::crypto_tokens_not_expected);
  const auto open = two.endpoints(endpoint_attributes(kNone, kNone));
  EXPECT_EQ(set_writer(two, open, {token}), Code::crypto_tokens_not_expected);
}

// Properties

TEST(CryptoProperties, KeySizeIs128Or256) {
  TwoSides two;
  const auto attributes = endpoint_attributes(kEncrypt, kNone);
  const auto kind_with = [&](const PropertyList& properties) {
    const auto e = two.endpoints(attributes, properties);
    const auto tokens = two.writer_tokens(e);
    return read_crypto_token(tokens->front())->kind;
  };
  EXPECT_EQ(kind_with({}), kAes256Gcm);
  EXPECT_EQ(kind_with(key_size("256")), kAes256Gcm);
  EXPECT_EQ(kind_with(key_size("128")), kAes128Gcm);
  for (const auto* const bad : {"", "192", "128 ", "0128", "AES256"})
    EXPECT_EQ(code_of(two.a.factory().register_local_datawriter(two.a.participant, key_size(bad),
                                                                attributes)),
              Code::invalid_property);
  EXPECT_EQ(code_of(two.a.factory().register_local_participant({}, {}, key_size("64"), {})),
            Code::invalid_property);
}

TEST(CryptoProperties, AnEmptySharedSecretIsRefused) {
  TwoSides two;
  EXPECT_EQ(code_of(two.a.factory().register_matched_remote_participant(two.a.participant, {9}, {},
                                                                        spi::SharedSecret{})),
            Code::length_out_of_range);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
