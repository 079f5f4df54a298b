// When keys have been in use for long enough, by the clock and by the amount that they protected.
#include "plugins/cryptography/key_life.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "plugins/cryptography/key_revision.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

using namespace std::chrono_literals;
namespace property = spi::property;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();

// ---- at which part of the limits a life ends

TEST(KeyLife, KeyWithoutLimits_NeverEnds) {
  KeyLife life;
  EXPECT_FALSE(life.is_limited());
  life.begin(5s, kMax);
  EXPECT_FALSE(life.has_ended(std::chrono::hours(24 * 10'000)));
  EXPECT_FALSE(life.counts_blocks(std::chrono::hours(24 * 10'000)));
}

// The time until keys that are made at that moment are in use, and the former ones do not count any
// more.
constexpr auto kMargin = kFormerKeyLife + KeyLife::kAsked;

TEST(KeyLife, TimeLimit_EndsInItsLastQuarter) {
  for (const auto whole : {spi::kMinKeyLifetime, 3600s, spi::kMaxKeyLifetime}) {
    for (const std::uint64_t chance : {std::uint64_t{0}, std::uint64_t{1}, kMax / 3, kMax}) {
      KeyLife life({.lifetime = whole});
      life.begin(100s, chance);
      EXPECT_TRUE(life.is_limited());
      EXPECT_FALSE(life.has_ended(100s + 3 * whole / 4 - kMargin - 1ns));
      EXPECT_TRUE(life.has_ended(100s + whole - kMargin));
      EXPECT_FALSE(life.has_ended(100s)) << "a revision has its time";
    }
  }
}

TEST(KeyLife, RandomChance_DrawsTheEnd) {
  const auto ends_by = [](std::uint64_t chance, std::chrono::seconds time) {
    KeyLife life({.lifetime = 1000s, .blocks = 1000});
    life.begin(0s, chance);
    return std::pair(life.has_ended(time), life.is_used_up(800));
  };
  EXPECT_EQ(ends_by(0, 988s), std::pair(false, false)) << "1000 - 11";
  EXPECT_EQ(ends_by(0, 989s).first, true);
  EXPECT_EQ(ends_by(200'000'000'000 + 250, 788s).first, false) << "1000 - 200 - 11";
  EXPECT_EQ(ends_by(200'000'000'000 + 250, 789s).first, true);
  EXPECT_EQ(ends_by(249, 0s).second, true);
  EXPECT_EQ(ends_by(251, 0s).second, false) << "comes round";
}

TEST(KeyLife, BlockLimit_EndsInItsLastQuarter) {
  for (const std::uint64_t most : {std::uint64_t{1}, std::uint64_t{100}, kMax})
    for (const std::uint64_t chance : {std::uint64_t{0}, std::uint64_t{1}, kMax}) {
      KeyLife life({.blocks = most});
      life.begin(0s, chance);
      EXPECT_FALSE(life.is_used_up(most / 4 * 3 - (most > 3 ? 1 : 0)));
      EXPECT_TRUE(life.is_used_up(most));
      EXPECT_FALSE(life.has_ended(std::chrono::hours(24 * 1000)));
    }
}

TEST(KeyLife, BlocksBeforeFormerKeysAreForgotten_AreNotCounted) {
  KeyLife life({.blocks = 1});
  life.begin(3s, 0);
  EXPECT_FALSE(life.counts_blocks(3s + kFormerKeyLife - 1ns));
  EXPECT_TRUE(life.counts_blocks(3s + kFormerKeyLife));
}

// ---- in the plugin

PropertyList lifetime(std::string value) {
  return {{std::string(property::kKeyLifetime), std::move(value)}};
}
PropertyList most_blocks(std::string value) {
  return {{std::string(property::kMaxBlocksPerKey), std::move(value)}};
}

struct Limited {
  explicit Limited(const PropertyList& properties, const CryptographyOptions& options = {})
      : two(participant_attributes(kEncrypt, true), properties, options) {}
  bool is_due() { return factory().is_key_revision_due(two.a.participant); }
  spi::CryptoKeyFactory& factory() { return two.a.factory(); }
  void revise() {
    const auto number = factory().revise_local_entity_keys(two.a.participant).value();
    EXPECT_FALSE(is_due()) << "it is under way";
    ASSERT_TRUE(factory().activate_key_revision(two.a.participant, number));
  }
  TwoSides two;
};

TEST(LimitedKeys, GovernanceWithoutRevision_RefusesLimits) {
  for (const auto& properties : {lifetime("3600"), most_blocks("1")}) {
    Side side;
    const auto refused = side.factory().register_local_participant(
        {1}, {1}, properties, participant_attributes(kEncrypt, false));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code(), Code::key_limits_without_revision);
    EXPECT_EQ(refused.error().details().field, properties[0].name);
    EXPECT_TRUE(side.factory().register_local_participant({1}, {1}, properties,
                                                          participant_attributes(kEncrypt, true)));
    EXPECT_TRUE(side.factory().register_local_participant({1}, {1}, lifetime("0"),
                                                          participant_attributes(kEncrypt, false)))
        << "nothing is asked for";
  }
}

TEST(LimitedKeys, MalformedLimits_MakeNoParticipant) {
  for (const auto& properties : {lifetime("soon"), lifetime("19"), most_blocks("-1")}) {
    Side side;
    for (const bool revises : {false, true}) {
      const auto refused = side.factory().register_local_participant(
          {1}, {1}, properties, participant_attributes(kEncrypt, revises));
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code(), Code::invalid_property);
    }
  }
}

TEST(LimitedKeys, EndedTime_MakesARevisionDue) {
  Limited limited(lifetime("100"));
  auto& clock = limited.two.a.clock;
  for (int i = 0; i < 3; ++i) {
    clock.advance(63s);
    EXPECT_FALSE(limited.is_due());
    clock.advance(26s);
    EXPECT_TRUE(limited.is_due());
    clock.advance(1000s);
    EXPECT_TRUE(limited.is_due()) << "until it is done";
    limited.revise();
    EXPECT_FALSE(limited.is_due());
  }
}

TEST(LimitedKeys, LimitsWithoutProperties_AreOff) {
  Limited limited(PropertyList{});
  limited.two.a.clock.advance(std::chrono::hours(24 * 365 * 20));
  EXPECT_FALSE(limited.is_due());
  EXPECT_FALSE(limited.factory().is_key_revision_due({}));
  EXPECT_FALSE(limited.factory().is_key_revision_due(limited.two.a.remote));
}

TEST(LimitedKeys, RevisionForAnyReason_StartsThemAnew) {
  Limited limited(lifetime("100"));
  limited.two.a.clock.advance(60s);
  limited.revise();
  limited.two.a.clock.advance(60s);
  EXPECT_FALSE(limited.is_due());
  limited.two.a.clock.advance(29s);
  EXPECT_TRUE(limited.is_due());
}

// The blocks of each key of a participant and its endpoints are counted separately.
TEST(LimitedKeys, WhatEachKeyProtects_IsCounted) {
  struct Row {
    std::string_view what;
    std::function<void(TwoSides&, const WriterToReader&)> send;
  };
  const Bytes payload(16 * 1024, 0x5a);
  const auto submessage = data_submessage(1024);
  for (const auto& [what, send] :
       {Row{"messages",
            [&](auto&two, auto&) { EXPECT_TRUE(encode_message(two, rtps_message({submessage}))); }},
        Row{"submessages",
            [&](auto&two, auto&e) { EXPECT_TRUE(encode_submessage(two, e, submessage)); }},
        Row{"payloads", [&](auto&two, auto&e) { EXPECT_TRUE(encode_payload(two, e, payload)); }}}) {
    Limited limited(most_blocks("4000"));
    const auto e = limited.two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
    limited.two.a.clock.advance(kFormerKeyLife);
    send(limited.two, e);
    EXPECT_FALSE(limited.is_due()) << what;
    for (int i = 0; i < 60; ++i) send(limited.two, e);
    EXPECT_TRUE(limited.is_due()) << what;
    limited.revise();
    limited.two.a.clock.advance(kFormerKeyLife);
    send(limited.two, e);
    EXPECT_FALSE(limited.is_due()) << what << ", with new keys";
  }
}

TEST(LimitedKeys, WhatAReaderSaysToAParticipant_IsCounted) {
  Limited limited(most_blocks("4000"));
  const auto e = limited.two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  auto& b = limited.two.b;
  const auto is_due = [&] { return b.factory().is_key_revision_due(b.participant); };
  b.clock.advance(kFormerKeyLife);
  const auto reply = data_submessage(24, 0x06);  // 3 blocks
  for (int i = 0; i < 900; ++i) EXPECT_TRUE(encode_reply(limited.two, e, reply));
  EXPECT_FALSE(is_due());
  for (int i = 0; i < 450; ++i) EXPECT_TRUE(encode_reply(limited.two, e, reply));
  EXPECT_TRUE(is_due());
}

TEST(LimitedKeys, FinishedSessions_AreCountedToo) {
  Limited limited(most_blocks("4000"), {.max_blocks_per_session = 500});
  limited.two.a.clock.advance(kFormerKeyLife);
  const auto message = rtps_message({data_submessage(1024)});
  int sent = 0;
  for (; !limited.is_due() && sent < 1000; ++sent)
    EXPECT_TRUE(encode_message(limited.two, message));
  EXPECT_GE(sent, 38) << "3000 blocks of about 70 a message";
  EXPECT_LE(sent, 60);
}

TEST(LimitedKeys, SmallestBlockLimit_RevisesEveryTenSeconds) {
  Limited limited(most_blocks("1"));
  const auto message = rtps_message({data_submessage(16)});
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(encode_message(limited.two, message));
    limited.two.a.clock.advance(kFormerKeyLife - 1ns);
    EXPECT_FALSE(limited.is_due());
    limited.two.a.clock.advance(1ns);
    EXPECT_TRUE(limited.is_due());
    limited.revise();
  }
  limited.two.a.clock.advance(1000s);
  EXPECT_FALSE(limited.is_due()) << "nothing was sent";
}

}  // namespace
}  // namespace ddssec::cryptography::testing
