// Each refusal of handles, tokens and properties, with its own code.
#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

// ---- handles

TEST(CryptoHandles, NilStaleForeignAndWrongKind_AreRefused) {
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

TEST(CryptoHandles, AReturnedPlace_GetsANewHandle) {
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

TEST(CryptoHandles, NilHandle_IsRefusedByEveryFunction) {
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

TEST(CryptoHandles, UnmatchedPairs_AreRefused) {
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

}  // namespace
}  // namespace ddssec::cryptography::testing
