// What discovery accepts only from proven participants, and what it announces to others.
#include "plugins/spi/session_reset.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

struct Matched : Pair {
  explicit Matched(const Rules& rules) : Pair(rules) { EXPECT_TRUE(match()); }
};

// Our plugins in Cyclone DDS answer in this way to a participant that sends on after the end of a
// session, as a revoked one does.
TEST(Enforcement, ASessionReset_IsNoDamagedMessage) {
  Matched pair({.rtps = kSign});
  const auto before = pair.b->protection_counters();
  const spi::ResetToken token{.name = {}, .proof = *spi::ResetProof::copy_of(Bytes(32))};
  pair.b->receive(spi::write_reset(pair.a->prefix(), token), pair.world.now);
  EXPECT_EQ(pair.b->protection_counters().undecodable, before.undecodable);
  EXPECT_FALSE(pair.b.events.has(Code::crypto_header_kind_unknown));
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 200));
}

TEST(Enforcement, AClearDisposeOfAnAuthenticatedParticipant_IsIgnored) {
  Matched pair({});
  const Guid victim{pair.a->prefix(), kEntityIdParticipant};
  const auto dispose = forged(
      victim.prefix,
      Data{kSpdpReader, kSpdpWriter, {9}, {victim.octets(), {true, true}}, PayloadKind::none, {}});
  pair.b->receive(dispose, pair.world.now);
  EXPECT_EQ(pair.b->remote_participants().size(), 1u);
  EXPECT_EQ(pair.b->counters().refused_discovery, 1u);
  EXPECT_EQ(pair.b.listener.matched, 1);
}

TEST(Enforcement, AClearAnnouncement_DoesNotShortenTheLeaseOfAnAuthenticatedParticipant) {
  Matched pair({});
  ParticipantData data;
  data.guid = {pair.a->prefix(), kEntityIdParticipant};
  data.lease_duration = Duration{{0, 1}};
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7666)};
  Bytes buffer(2048);
  SpanWriter out(buffer);
  write_payload(out, data);
  pair.b->receive(forged(data.guid.prefix,
                         Data{kSpdpReader, kSpdpWriter, {9}, {}, PayloadKind::data, out.view()}),
                  pair.world.now);
  pair.world.run(50);
  EXPECT_EQ(pair.b.listener.matched, 1);
  for (const auto& [port, octets] : pair.b.post.sent) EXPECT_NE(port, 7666u);
}

// One such datagram of a stranger must not keep a participant busy for ten seconds.
TEST(Enforcement, ALeaseOfNoTime_CausesNoEndlessWork) {
  Matched pair({});
  auto data = secured_data(fake_prefix(1));
  data.lease_duration = Duration{{0, 1}};
  pair.b->receive(announcement(data), pair.world.now);
  ASSERT_EQ(pair.b->remote_participants().size(), 2u);
  int ticks = 0;
  for (auto now = pair.world.now; now < pair.world.now + std::chrono::seconds(5) && ticks < 5000;
       ++ticks) {
    now = std::max(now, pair.b->next_tick());
    pair.b->tick(now);
  }
  EXPECT_LT(ticks, 500);
}

TEST(Enforcement, WhatSecureDiscoverySaid_IsNotUnsaidInTheClear) {
  Matched pair({.discovery = kEncrypt});
  Bytes buffer(64);
  SpanWriter out(buffer);
  write_endpoint_key(out, pair.writer);
  const Data dispose{
      kPublicationsReader, kPublicationsWriter, {1}, {pair.writer.octets(), {true, true}},
      PayloadKind::key,    out.view()};
  pair.b->receive(forged(pair.a->prefix(), dispose), pair.world.now);
  EXPECT_EQ(pair.b.listener.matched, 1);
  EXPECT_GE(pair.b->counters().refused_discovery, 1u);
}

TEST(Enforcement, AnEndpointOfAProtectedTopic_MustBeAnnouncedSecurely) {
  Matched pair({.discovery = kSign});
  EndpointData data;
  data.guid = {pair.a->prefix(), {{0, 0, 99, 0x02}}};
  data.topic_name = "Square";
  data.type_name = "ShapeType";
  data.qos = default_writer_qos();
  Bytes buffer(2048);
  SpanWriter out(buffer);
  write_payload(out, data);
  pair.b->receive(
      forged(
          pair.a->prefix(),
          Data{kPublicationsReader, kPublicationsWriter, {1}, {}, PayloadKind::data, out.view()}),
      pair.world.now);
  EXPECT_EQ(pair.b.listener.matched, 1);
  EXPECT_TRUE(pair.b.events.has(Code::rtps_protection_missing));
}

// Fast DDS without security matches no endpoint that announces empty masks.
TEST(Enforcement, Masks_AreLeftOutWhereStrangersMayReadAndNothingIsProtected) {
  const auto announced = [](const Rules& rules) {
    Pair pair(rules);
    EXPECT_TRUE(pair.match());
    return pair.b->remote_participants().endpoint(pair.writer)->security_info.has_value();
  };
  EXPECT_FALSE(announced({.allow_unauthenticated = true, .access_control = false}));
  EXPECT_TRUE(announced({.allow_unauthenticated = true}));
  EXPECT_TRUE(announced({.access_control = false}));
  EXPECT_TRUE(
      announced({.metadata = kSign, .allow_unauthenticated = true, .access_control = false}));
}

}  // namespace
}  // namespace ddssec::rtps
