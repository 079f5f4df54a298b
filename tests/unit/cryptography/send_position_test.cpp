#include "plugins/cryptography/send_position.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
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

// The position of a sender in its third session.
const SendPosition kThird{12, 1000, {{10, 2}}};

TEST(SendPosition, WhatWasProtectedBefore_HasPassed) {
  EXPECT_TRUE(kThird.has_passed(iv(12, 999)));
  EXPECT_FALSE(kThird.has_passed(iv(12, 1000)));
  EXPECT_FALSE(kThird.has_passed(iv(13, 0)));
  EXPECT_TRUE(kThird.has_passed(iv(11, 5000))) << "a session that is over, whatever its count";
  EXPECT_TRUE(kThird.has_passed(iv(10, 0)));
  EXPECT_FALSE(kThird.has_passed(iv(9, 0))) << "never one of the sender's";
}

TEST(SendPosition, PositionAfterTheGreatestNumbers_CountsOn) {
  const SendPosition wraps{1, 5, {{0xfffffffe, 3}}};
  EXPECT_TRUE(wraps.has_passed(iv(0xffffffff, 7)));
  EXPECT_TRUE(wraps.has_passed(iv(1, 0xfffffffffffffff0)));
  EXPECT_FALSE(wraps.has_passed(iv(1, 5)));
  EXPECT_FALSE(wraps.has_passed(iv(2, 0)));
}

TEST(SendPosition, PositionsThatItsSenderHasLeft_AreBefore) {
  EXPECT_FALSE(kThird.is_after(kThird));
  EXPECT_TRUE(kThird.is_after({12, 999, {{10, 2}}}));
  EXPECT_TRUE(kThird.is_after({11, 5000, {{10, 1}}}));
  EXPECT_FALSE(kThird.is_after({13, 0, {{10, 3}}}));
  EXPECT_FALSE(kThird.is_after({700, 0, {{700, 0}, {10, 2}}})) << "a child's";
}

TEST(SendPosition, SessionsBeforeAFork_HavePassed) {
  const SendPosition child{700, 0, {{700, 0}, {10, 2}}};
  EXPECT_TRUE(child.has_passed(iv(12, 1)));
  EXPECT_FALSE(child.has_passed(iv(700, 0)));
}

TEST(SendPosition, WrittenPosition_ReadsBack) {
  SendPosition position{12, 1000, {{10, 2}, {90, 0}}};
  EXPECT_EQ(parse_send_position(serialize(position)), position);
  position.begun.resize(SendPosition::kMaxRanges + 1);
  EXPECT_EQ(parse_send_position(serialize(position))->begun.size(), SendPosition::kMaxRanges);
  const auto octets = serialize(position);
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_EQ(parse_send_position(BytesView(octets).first(size)).has_value(),
              size >= 20 && size % 8 == 4)
        << size;
  auto longer = octets;
  longer.resize(octets.size() + 8);
  EXPECT_FALSE(parse_send_position(longer));
}

TEST(SendPosition, AnotherPosition_IsStillTheSameKey) {
  KeyMaterial key{.kind = kAes256Gcm, .sender_key_id = {{1, 2, 3, 4}}};
  key.salt = *MasterSalt::copy_of(Bytes(32, 1));
  key.sender_key = *MasterKey::copy_of(Bytes(32, 2));
  auto moved = key.clone();
  moved.position = kThird;
  EXPECT_EQ(moved, key);
  const auto read = parse_key_material(serialize_key_material(moved));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->position, kThird);
  EXPECT_EQ(*read, key);
}

// ---- in the plugin

constexpr GuidPrefix kPeerOfB{{0x90, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr EntityId kWriter{{0, 0, 1, 2}};

// `a` keeps its keys while the two participants lose each other and meet again.
struct LostAndFound : ::testing::Test {
  spi::SharedSecret secret(std::uint8_t seed) const {
    auto out = testing::shared_secret(seed);
    out.peer_prefix = kPeerOfB;
    out.peer_ciphers = is_ours ? spi::kAllCiphers : spi::kStandardCiphers;
    return out;
  }
  void meet(std::uint8_t seed) {
    auto& a = two.a;
    a.remote =
        a.factory()
            .register_matched_remote_participant(a.participant, {60 + seed}, {7}, secret(seed))
            .value();
    ends.remote_reader =
        a.factory()
            .register_matched_remote_datareader(ends.writer, a.remote, secret(seed), false)
            .value();
    auto& b = two.b;
    b.remote =
        b.factory()
            .register_matched_remote_participant(b.participant, {40 + seed}, {7}, secret(seed))
            .value();
    ends.remote_writer =
        b.factory().register_matched_remote_datawriter(ends.reader, b.remote, secret(seed)).value();
    two.take_writer(ends, two.writer_tokens(ends).value()).value();
  }
  void begin(spi::ProtectionKind kind = spi::ProtectionKind::encrypt) {
    if (two.a.remote) lose();
    for (auto* side : {&two.a, &two.b}) testing::TwoSides::match(*side);
    ends = two.endpoints(testing::endpoint_attributes(kind, spi::ProtectionKind::none));
    lose();
    meet(5);
  }
  void lose() {
    for (auto* side : {&two.a, &two.b})
      ASSERT_TRUE(side->factory().unregister_participant(std::exchange(side->remote, {})));
  }
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

TEST_F(LostAndFound, WhatCameBefore_IsNotNew) {
  begin();
  const auto first = sent(), second = sent(), missed = sent();
  EXPECT_TRUE(got(first));
  EXPECT_TRUE(got(second));
  EXPECT_TRUE(got(first)) << "within a session the host knows the numbers";
  lose();
  meet(6);
  for (const auto& recorded : {first, second, missed})
    EXPECT_EQ(testing::code_of(got(recorded)), Code::message_from_before);
  EXPECT_TRUE(got(sent()));
}

// The host passes messages that one reader can read on to all readers of the same writer.
TEST_F(LostAndFound, ALaterReader_MakesNothingNewThatTheWriterSentBeforeIt) {
  for (const auto kind : {spi::ProtectionKind::encrypt, spi::ProtectionKind::sign,
                          spi::ProtectionKind::encrypt_with_origin_authentication}) {
    begin(kind);
    const auto first = sent(), missed = sent();
    EXPECT_TRUE(got(first));
    auto later = ends;
    const auto attributes = testing::endpoint_attributes(kind, spi::ProtectionKind::none);
    later.reader =
        two.b.factory().register_local_datareader(two.b.participant, {}, attributes).value();
    two.match_endpoints(later);
    for (const auto& recorded : {first, missed})
      EXPECT_EQ(testing::code_of(got(recorded)), Code::message_from_before);
    EXPECT_TRUE(got(sent())) << "what comes is new to both";
    const auto under_way = sent();
    two.take_writer(later, two.writer_tokens(later).value()).value();
    EXPECT_TRUE(got(under_way)) << "the later reader got its tokens again, and is not later for it";
    ASSERT_TRUE(two.b.factory().unregister_datareader(ends.reader));
    const auto reached = [&](const Bytes& encoded) {
      return testing::decode_submessage(two, later, encoded);
    };
    EXPECT_FALSE(reached(first));
    lose();
  }
}

// Only payloads are protected. Cyclone DDS opens them for all readers with the key of the first
// one.
struct LaterPayloads : ::testing::TestWithParam<bool> {
  testing::TwoSides two{spi::ProtectionKind::none, {}, {.host_checks_sources = GetParam()}};
};

TEST_P(LaterPayloads, SentBeforeTheReaderCame_AreNotNew) {
  for (const auto kind : {spi::ProtectionKind::sign, spi::ProtectionKind::encrypt}) {
    const auto attributes = testing::endpoint_attributes(spi::ProtectionKind::none, kind);
    const auto first = two.endpoints(attributes);
    const auto sent = [&] { return testing::encode_payload(two, first, Bytes(16, 7)).value(); };
    const auto got = [&](const testing::WriterToReader& by, const Bytes& encoded) {
      return testing::code_of(testing::decode_payload(two, by, encoded));
    };
    const auto recorded = sent();
    EXPECT_EQ(got(first, recorded), Code{});
    EXPECT_EQ(got(first, recorded), Code{})
        << "for each reader, and for each fragment that is lost";
    auto later = first;
    later.reader =
        two.b.factory().register_local_datareader(two.b.participant, {}, attributes).value();
    two.match_endpoints(later);
    EXPECT_EQ(got(later, recorded), Code::message_from_before);
    EXPECT_EQ(got(first, recorded), GetParam() ? Code{} : Code::message_from_before);
    const auto now = sent();
    EXPECT_EQ(got(first, now), Code{});
    EXPECT_EQ(got(later, now), Code{});
  }
}

INSTANTIATE_TEST_SUITE_P(Hosts, LaterPayloads, ::testing::Bool(), [](const auto& run) {
  return std::string(run.param ? "HostThatChecksSources" : "OtherHost");
});

// The process of the receiver has just started, so it remembers nothing.
TEST_F(LostAndFound, WhatWasSentToOthersBefore_IsNotNew) {
  ends = two.endpoints(
      testing::endpoint_attributes(spi::ProtectionKind::encrypt, spi::ProtectionKind::none));
  const auto recorded = sent();
  lose();
  meet(5);
  EXPECT_EQ(testing::code_of(got(recorded)), Code::message_from_before);
  EXPECT_TRUE(got(sent()));
}

TEST_F(LostAndFound, EverySession_Counts) {
  begin();
  const auto first = sent();
  EXPECT_TRUE(got(first));
  for (std::uint8_t seed = 6; seed < 9; ++seed) {
    lose();
    meet(seed);
    EXPECT_EQ(testing::code_of(got(first)), Code::message_from_before);
    EXPECT_TRUE(got(sent()));
  }
}

// Fast DDS draws each IV at random.
TEST_F(LostAndFound, OtherProducts_MayCountAsTheyLike) {
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
