// A message without the protection that its reader or writer requires changes nothing.
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/keyrings.hpp"
#include "wire/acknack.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps::keyrings {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

// For instance, the MACs of all readers do not fit a datagram. MessageSender calls this, as
// message_sender_test.cpp shows.
TEST(KeyringTransform, MessageThatCannotBeProtected_IsCountedAndReported) {
  Protected pair({.metadata = kEncrypt});
  auto& keyring =
      const_cast<ParticipantCore&>(pair.a->remote_participants().core()).security->keyring();
  const auto before = pair.a->protection_counters().unsendable;
  keyring.on_unprotectable(Error(Code::length_out_of_range, {.document = "receiver MACs"}));
  EXPECT_EQ(pair.a->protection_counters().unsendable, before + 1);
  EXPECT_EQ(pair.a.events.count(Code::length_out_of_range), 1);
  keyring.on_unprotectable(Error(Code::crypto_not_matched));  // too early, not too large
  EXPECT_EQ(pair.a->protection_counters().unsendable, before + 2);
  EXPECT_FALSE(pair.a.events.has(Code::crypto_not_matched));
}

TEST(KeyringTransform, ClearSubmessagesOfProtectedEndpoints_AreDroppedAndCounted) {
  for (const auto& rules : {Rules{.metadata = kSign}, Rules{.rtps = kSign}}) {
    Protected pair(rules);
    const auto& from = pair.a->prefix();
    const auto before = pair.b->protection_counters().unprotected;
    pair.b->receive(forged(from, pair.data(1)), pair.world.now);
    pair.b->receive(
        forged(from,
               Heartbeat{kEntityIdUnknown, pair.writer.entity, {1}, {900}, 900, false, false}),
        pair.world.now);
    pair.b->receive(forged(from, Gap{kEntityIdUnknown,
                                     pair.writer.entity,
                                     {1},
                                     SequenceNumberSet(SequenceNumber{1000})}),
                    pair.world.now);
    EXPECT_EQ(pair.b->protection_counters().unprotected, before + 3);
    EXPECT_TRUE(pair.b.events.has(Code::rtps_protection_missing));
    const auto at_a = pair.a->protection_counters().unprotected;
    pair.a->receive(
        forged(pair.b->prefix(), AckNack{pair.reader.entity, pair.writer.entity,
                                         SequenceNumberSet(SequenceNumber{1}), 1 << 30, true}),
        pair.world.now);
    EXPECT_EQ(pair.a->protection_counters().unprotected, at_a + 1);
    // The honest writer goes on as if nothing had arrived.
    pair.write();
    EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 200));
  }
}

TEST(KeyringTransform, APlainPayloadWhereProtectionIsDue_IsDropped) {
  Protected pair({.data = kEncrypt});
  pair.b->receive(forged(pair.a->prefix(), pair.data(1)), pair.world.now);
  EXPECT_TRUE(pair.b.listener.changes.empty());
  EXPECT_EQ(pair.b->protection_counters().undecodable, 1u);
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 200));
}

// The payload key protects nothing of such a dispose. Our writers send the key as a payload, so
// that it is protected.
TEST(KeyringTransform, ADisposeWithoutAPayloadWherePayloadsAreProtected_IsDropped) {
  for (const auto kind : {kSign, kEncrypt}) {
    Protected pair({.data = kind});
    auto dispose = pair.data(1);
    dispose.payload = {};
    dispose.kind = PayloadKind::none;
    dispose.inline_qos.status = {true, false};
    dispose.inline_qos.key_hash = KeyHash{1};
    pair.b->receive(forged(pair.a->prefix(), dispose), pair.world.now);
    dispose.inline_qos.status = {false, true};
    pair.b->receive(forged(pair.a->prefix(), dispose), pair.world.now);
    EXPECT_TRUE(pair.b.listener.changes.empty());
    EXPECT_EQ(pair.b->protection_counters().unprotected, 2u);
    EXPECT_TRUE(pair.b.events.has(Code::rtps_protection_missing));
    Change honest;
    honest.status = {true, false};
    honest.key_hash = KeyHash{1};
    honest.is_key_only = true;
    honest.payload = payload();
    pair.a->local_endpoints().writer(pair.writer)->write(std::move(honest), pair.world.now);
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 200));
    EXPECT_TRUE(pair.b.listener.changes[0].status.disposed);
  }
}

// A message of an unknown sender may have come too early, so it is counted, without an event for
// each.
TEST(KeyringTransform, GroupOfAnUnknownSender_IsCountedWithoutAnEvent) {
  Protected pair({.metadata = kSign});
  pair.world.run(200);
  pair.a.post.sent.clear();
  pair.write();
  ASSERT_FALSE(pair.a.post.sent.empty());
  auto stranger = pair.a.post.sent.front().second;
  std::ranges::fill(std::span(stranger).subspan(8, GuidPrefix::size), std::uint8_t{9});
  const auto before = pair.b->protection_counters().undecodable;
  const auto events = pair.b.events.text();
  pair.b->receive(stranger, pair.world.now);
  EXPECT_GT(pair.b->protection_counters().undecodable, before);
  EXPECT_EQ(pair.b.events.text(), events);
  EXPECT_TRUE(pair.b.listener.changes.empty());
}

}  // namespace
}  // namespace ddssec::rtps::keyrings
