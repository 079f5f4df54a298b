#include "plugins/cryptography/latest_iv.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

Iv iv(std::uint32_t session, std::uint64_t block) {
  Iv out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(session >> (24 - 8 * i));
  for (std::size_t i = 0; i < 8; ++i) out[4 + i] = static_cast<std::uint8_t>(block >> (56 - 8 * i));
  return out;
}

TEST(LatestIv, GrowsWithTheSendersCount) {
  LatestIv latest;
  EXPECT_EQ(latest.latest(), 0u);
  EXPECT_FALSE(latest.place_of(iv(7, 100)));
  latest.note(iv(7, 100));
  const auto first = latest.latest();
  EXPECT_EQ(latest.place_of(iv(7, 100)), first);
  latest.note(iv(7, 90));  // reordered on its way
  EXPECT_EQ(latest.latest(), first);
  EXPECT_LT(latest.place_of(iv(7, 99)), first);
  EXPECT_GT(latest.place_of(iv(7, 101)), first);
  EXPECT_GT(latest.place_of(iv(8, 0)), first) << "a session begins where the former did";
  EXPECT_LT(latest.place_of(iv(6, 200)), first);
  latest.note(iv(8, 3));
  EXPECT_GT(latest.latest(), first);
}

TEST(LatestIv, CountsPastTheGreatestNumbers) {
  LatestIv latest;
  latest.note(iv(0xffffffff, ~std::uint64_t{0} - 1));
  const auto first = latest.latest();
  EXPECT_GT(latest.place_of(iv(0xffffffff, 5)), first);
  EXPECT_GT(latest.place_of(iv(0, ~std::uint64_t{0} - 1)), first);
}

TEST(LatestIv, ASenderThatBeginsElsewhereHasNoOrder) {
  LatestIv latest;
  latest.note(iv(7, 100));
  EXPECT_NE(latest.latest(), 0u);
  latest.note(iv(0x70000000, 5));
  EXPECT_EQ(latest.latest(), 0u);
}

KeyMaterial key_of(std::uint8_t octet) {
  KeyMaterial out;
  out.kind = kAes256Gcm;
  out.sender_key_id = {{1, 2, 3, octet}};
  out.salt = *MasterSalt::copy_of(Bytes(32, octet));
  out.sender_key = *MasterKey::copy_of(Bytes(32, octet));
  return out;
}

TEST(LatestIvs, BelongToAKeyAndACertificate) {
  LatestIvs all;
  const LatestIvs::Subject one{1}, other{2};
  const auto first = all.of(one, key_of(1));
  EXPECT_EQ(all.of(one, key_of(1)), first);
  EXPECT_NE(all.of(one, key_of(2)), first);
  EXPECT_NE(all.of(other, key_of(1)), first);
  auto for_us = key_of(1);
  for_us.receiver_key_id = {{9}};
  EXPECT_EQ(all.of(one, for_us), first) << "the sender's key counts";
}

TEST(LatestIvs, OfManyOfOneCertificateTheFirstGiveWay) {
  LatestIvs all;
  const LatestIvs::Subject one{1}, other{2};
  const auto mine = all.of(other, key_of(1));
  const auto first = all.of(one, key_of(0));
  auto key = key_of(0);
  for (std::size_t i = 1; i <= LatestIvs::kMostOfSubject; ++i) {
    Bytes octets(32, 0);
    octets[0] = static_cast<std::uint8_t>(i >> 8);
    octets[1] = static_cast<std::uint8_t>(i);
    key.sender_key = *MasterKey::copy_of(octets);
    all.of(one, key);
  }
  EXPECT_NE(all.of(one, key_of(0)), first);
  EXPECT_EQ(all.of(other, key_of(1)), mine);
}

// ---- in the engine

constexpr GuidPrefix kPeerOfB{{0x90, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr EntityId kWriter{{0, 0, 1, 2}};

/// `a` keeps its keys while `b` loses it and meets it again.
struct LostAndFound : ::testing::Test {
  spi::SharedSecret secret(std::uint8_t seed) const {
    auto out = testing::shared_secret(seed);
    out.peer_prefix = kPeerOfB;
    out.peer_ciphers = is_ours ? spi::kAllCiphers : spi::kStandardCiphers;
    return out;
  }
  void meet(std::uint8_t seed) {
    auto& b = two.b;
    b.remote =
        b.factory()
            .register_matched_remote_participant(b.participant, {40 + seed}, {7}, secret(seed))
            .value();
    ends.remote_writer =
        b.factory().register_matched_remote_datawriter(ends.reader, b.remote, secret(seed)).value();
    two.take_writer(ends, two.writer_tokens(ends).value()).value();
  }
  void begin() {
    ends = two.endpoints(
        testing::endpoint_attributes(spi::ProtectionKind::encrypt, spi::ProtectionKind::none));
    ASSERT_TRUE(two.b.factory().unregister_participant(two.b.remote));
    meet(5);
  }
  void lose() { ASSERT_TRUE(two.b.factory().unregister_participant(two.b.remote)); }
  Bytes sent() {
    const auto message = testing::DataMessage{.writer = kWriter, .number = ++number}.octets();
    return testing::encode_submessage(two, ends, message).value();
  }
  Result<Bytes> got(const Bytes& encoded) { return testing::decode_submessage(two, ends, encoded); }

  bool is_ours = true;
  std::uint32_t number = 0;
  testing::TwoSides two{spi::ProtectionKind::none};
  testing::WriterToReader ends;
};

TEST_F(LostAndFound, WhatCameBeforeIsNotNew) {
  begin();
  const auto first = sent(), second = sent();
  EXPECT_TRUE(got(first));
  EXPECT_TRUE(got(second));
  EXPECT_TRUE(got(first)) << "within a session the host knows the numbers";
  const auto missed = sent();
  lose();
  meet(6);
  for (const auto& recorded : {first, second})
    EXPECT_EQ(testing::code_of(got(recorded)), Code::message_of_former_session);
  EXPECT_TRUE(got(missed));
  EXPECT_TRUE(got(sent()));
}

TEST_F(LostAndFound, EverySessionCounts) {
  begin();
  const auto first = sent();
  EXPECT_TRUE(got(first));
  for (std::uint8_t seed = 6; seed < 9; ++seed) {
    lose();
    meet(seed);
    EXPECT_EQ(testing::code_of(got(first)), Code::message_of_former_session);
    EXPECT_TRUE(got(sent()));
  }
}

// Fast DDS draws each IV at random.
TEST_F(LostAndFound, OtherProductsMayCountAsTheyLike) {
  is_ours = false;
  begin();
  const auto first = sent(), second = sent();
  EXPECT_TRUE(got(second));
  lose();
  meet(6);
  EXPECT_EQ(testing::code_of(got(first)), Code{});
}

}  // namespace
}  // namespace ddssec::cryptography
