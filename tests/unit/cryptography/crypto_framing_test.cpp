// The octets around protected content: what is read back, and which forms are refused.
#include "plugins/cryptography/crypto_framing.hpp"

#include <gmock/gmock.h>

#include "plugins/cryptography/key_material.hpp"
#include "tests/support/code_of.hpp"

namespace ddssec::cryptography {
namespace {

using test::code_of;

constexpr KeyId kKey{{1, 2, 3, 4}};
constexpr Iv kIv{9, 9, 9, 9, 1, 2, 3, 4, 5, 6, 7, 8};

// Returns CryptoHeader, the content, and a footer with the number of receiver-specific MACs.
Bytes payload(TransformKind kind, BytesView content, std::uint32_t macs = 0) {
  Bytes out(kCryptoHeaderSize + content.size() + kFooterSize + 4);
  UncheckedWriter pen(out);
  pen.crypto_header(kind, kKey, kIv);
  if (kind == kAes256Gcm) pen.u32(static_cast<std::uint32_t>(content.size()));
  pen.put(content);
  pen.zeros(kTagSize);
  pen.u32(macs);
  out.resize(pen.written());
  return out;
}

TEST(ProtectedPayload, EncodedPayload_ComesBackInItsParts) {
  for (const auto kind : {kAes256Gcm, kAes256Gmac}) {
    const auto octets = payload(kind, Bytes(8, 5));
    const auto read = read_protected_payload(octets);
    ASSERT_TRUE(read) << read.error().to_sentence();
    EXPECT_EQ(read->is_encrypted, kind == kAes256Gcm);
    EXPECT_EQ(read->header.key_id, kKey);
    EXPECT_EQ(read->header.iv, kIv);
    EXPECT_EQ(to_bytes(read->content), Bytes(8, 5));
  }
}

TEST(ProtectedPayload, PayloadWithMacsOfReceivers_IsRefused) {
  EXPECT_EQ(code_of(read_protected_payload(payload(kAes256Gcm, Bytes(8), 1))),
            Code::receiver_specific_macs_not_allowed);
}

TEST(ProtectedPayload, LongerOrShorterThanItsLength_IsRefused) {
  auto octets = payload(kAes256Gcm, Bytes(8));
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_THAT(code_of(read_protected_payload(BytesView(octets).first(size))),
                ::testing::AnyOf(Code::truncated, Code::secure_group_malformed))
        << size;
  octets.resize(octets.size() + 3);
  EXPECT_TRUE(read_protected_payload(octets)) << "filled up to a word";
  octets.resize(octets.size() + 1);
  EXPECT_EQ(code_of(read_protected_payload(octets)), Code::secure_group_malformed);
}

TEST(ProtectedPayload, UnknownKind_IsRefused) {
  EXPECT_EQ(code_of(read_protected_payload(payload(TransformKind{{0, 0, 0, 99}}, Bytes(8)))),
            Code::crypto_header_kind_unknown);
}

// Returns SEC_PREFIX, a signed submessage, and SEC_POSTFIX with the MAC of one receiver.
Bytes group() {
  Bytes out(200);
  UncheckedWriter pen(out);
  pen.submessage_header(submessage_id::kSecPrefix, kCryptoHeaderSize);
  pen.crypto_header(kAes256Gmac, kKey, kIv);
  pen.submessage_header(submessage_id::kAckNack, 24);
  pen.zeros(24);
  pen.submessage_header(submessage_id::kSecPostfix, kFooterSize + kReceiverMacSize);
  pen.zeros(kTagSize);
  pen.u32(1);
  pen.put(kKey.octets);
  pen.put(Bytes(kTagSize, 7));
  out.resize(pen.written());
  return out;
}

TEST(ProtectedGroup, EncodedGroup_ComesBackInItsParts) {
  const auto octets = group();
  const auto read = read_protected_group(octets, kSubmessageFrame);
  ASSERT_TRUE(read) << read.error().to_sentence();
  EXPECT_FALSE(read->is_encrypted);
  EXPECT_EQ(read->content.size(), 28u);
  const auto mac = read->footer.receiver_mac(kKey);
  ASSERT_TRUE(mac);
  EXPECT_EQ(mac->front(), 7);
  EXPECT_FALSE(read->footer.receiver_mac(KeyId{{4, 4, 4, 4}}));
}

TEST(ProtectedGroup, CutOffAnywhere_IsRefused) {
  const auto octets = group();
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_THAT(code_of(read_protected_group(BytesView(octets).first(size), kSubmessageFrame)),
                ::testing::AnyOf(Code::truncated, Code::secure_group_malformed))
        << size;
}

TEST(ProtectedGroup, GroupInAnotherFrameOrWithOtherFlags_IsRefused) {
  auto octets = group();
  EXPECT_EQ(code_of(read_protected_group(octets, kMessageFrame)), Code::secure_group_malformed);
  octets[1] |= 0x80;
  EXPECT_EQ(code_of(read_prefix(octets, kSubmessageFrame)), Code::secure_flags_unsupported);
}

}  // namespace
}  // namespace ddssec::cryptography
