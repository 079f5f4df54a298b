// What decoding refuses. A refused message leaves no plain octets and uses up nothing.
#include <algorithm>
#include <span>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr std::array kKinds = {kSign, kEncrypt, ProtectionKind::sign_with_origin_authentication,
                               ProtectionKind::encrypt_with_origin_authentication};

constexpr std::uint8_t kData = 0x15, kAckNack = 0x06;
constexpr std::size_t kSubmessageHeader = 4;

// A submessage of a writer, and the writer and reader that share its keys.
struct Pair {
  explicit Pair(ProtectionKind kind) : endpoints(two.endpoints(endpoint_attributes(kind, kNone))) {}
  Bytes encoded(BytesView plain) { return encode_submessage(two, endpoints, plain).value(); }
  Result<std::size_t> decode(BytesView encoded, MutableBytes out) {
    return two.b.transform().decode_datawriter_submessage(endpoints.reader, endpoints.remote_writer,
                                                          encoded, out);
  }
  TwoSides two;
  WriterToReader endpoints;
};

bool contains(BytesView octets, BytesView part) {
  return !std::ranges::search(octets, part).empty();
}

TEST(TransformDecode, OneOctetChanged_IsRefusedAndLeavesNoPlainOctets) {
  const auto plain = data_submessage(32);
  const auto secret = BytesView(plain).subspan(kSubmessageHeader);
  for (const auto kind : kKinds) {
    Pair pair(kind);
    std::size_t ignored = 0;
    for (std::size_t i = 0; i < pair.encoded(plain).size(); ++i) {
      auto changed = pair.encoded(plain);
      changed[i] ^= 0x10;
      Bytes out(changed.size());
      const auto size = pair.decode(changed, out);
      if (!size) {
        EXPECT_FALSE(contains(out, secret)) << i << " " << to_string(kind);
        continue;
      }
      EXPECT_EQ(to_bytes(BytesView(out).first(*size)), plain) << i << " " << to_string(kind);
      ++ignored;
    }
    EXPECT_LE(ignored, 3u) << "the reserved flags of three submessage headers";
  }
}

TEST(TransformDecode, CutOffAnywhere_IsRefusedAndLeavesNoPlainOctets) {
  const auto plain = data_submessage(32);
  for (const auto kind : kKinds) {
    Pair pair(kind);
    const auto encoded = pair.encoded(plain);
    for (std::size_t size = 0; size < encoded.size(); ++size) {
      Bytes out(encoded.size());
      EXPECT_FALSE(pair.decode(BytesView(encoded).first(size), out)) << size;
      EXPECT_EQ(out, Bytes(encoded.size())) << size << " " << to_string(kind);
    }
  }
}

// An attacker on the path who changes copies must not make the original useless.
TEST(TransformDecode, ChangedCopiesBefore_DoNotUseUpTheOriginal) {
  const auto plain = data_submessage(16);
  for (const auto kind : kKinds) {
    Pair pair(kind);
    const auto encoded = pair.encoded(plain);
    Bytes out(encoded.size());
    for (std::size_t i = 0; i < encoded.size(); ++i) {
      auto changed = encoded;
      changed[i] ^= 0x01;
      (void)pair.decode(changed, out);
    }
    EXPECT_EQ(decode_submessage(pair.two, pair.endpoints, encoded).value(), plain)
        << to_string(kind);
  }
}

TEST(TransformDecode, OtherKindOfProtection_IsNamed) {
  Pair encrypts(kEncrypt), signs(kSign);
  Bytes out(500);
  const auto encrypted = encrypts.encoded(data_submessage(16));
  const auto signed_only = signs.encoded(data_submessage(16));
  EXPECT_EQ(code_of(encrypts.decode(signed_only, out)), Code::signed_where_encryption_is_due);
  EXPECT_EQ(code_of(signs.decode(encrypted, out)), Code::encrypted_where_signature_is_due);
}

TEST(TransformDecode, KeyOfAnotherWriter_IsNamed) {
  Pair one(kEncrypt);
  const auto other = one.two.endpoints(endpoint_attributes(kEncrypt, kNone));
  const auto encoded = encode_submessage(one.two, other, data_submessage(16)).value();
  Bytes out(encoded.size());
  EXPECT_EQ(code_of(one.decode(encoded, out)), Code::transform_key_id_mismatch);
}

// Without origin authentication the plugin accepts the copy, because the host itself drops a
// message that arrives twice.
TEST(TransformDecode, SecondCopyWithOriginAuthentication_IsRefusedAndLeavesNoPlainOctets) {
  for (const auto kind : std::span(kKinds).last(2)) {
    Pair pair(kind);
    const auto encoded = pair.encoded(data_submessage(16));
    Bytes out(encoded.size());
    ASSERT_TRUE(pair.decode(encoded, out));
    std::ranges::fill(out, std::uint8_t{0});
    EXPECT_EQ(code_of(pair.decode(encoded, out)), Code::message_repeated);
    EXPECT_EQ(out, Bytes(encoded.size())) << to_string(kind);
  }
}

// The owner of a key sends submessages of one direction only.
TEST(TransformDecode, SubmessageOfTheOtherDirection_IsRefusedWithAnEvent) {
  Pair pair(kEncrypt);
  Bytes out(500);
  const auto of_writer = pair.encoded(data_submessage(16, kAckNack));
  EXPECT_EQ(code_of(pair.decode(of_writer, out)), Code::submessage_not_of_sender);
  EXPECT_EQ(out, Bytes(500)) << "no plain octets";
  const auto of_reader = encode_reply(pair.two, pair.endpoints, data_submessage(16, kData)).value();
  EXPECT_EQ(code_of(decode_reply(pair.two, pair.endpoints, of_reader)),
            Code::submessage_not_of_sender);
}

TEST(TransformDecode, TooLittleRoom_IsRefusedAndTheMessageStillCounts) {
  const auto plain = data_submessage(64);
  Pair pair(kEncrypt);
  const auto encoded = pair.encoded(plain);
  Bytes small(plain.size() - 1);
  EXPECT_EQ(code_of(pair.decode(encoded, small)), Code::length_out_of_range);
  EXPECT_EQ(small, Bytes(small.size()));
  EXPECT_EQ(decode_submessage(pair.two, pair.endpoints, encoded).value(), plain);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
