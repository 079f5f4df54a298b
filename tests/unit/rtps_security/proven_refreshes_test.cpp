// What is left of forged announcements when discovery becomes protected.
#include "rtps/participant/proven_refreshes.hpp"

#include "rtps/discovery/serialized.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/governance_changes.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

struct Case {
  Rules before, after;
  bool secure;  // the forged announcement is one of secure discovery
};

bool knows_forged(Fleet& fleet) {
  const auto& known =
      fleet.a.node->remote_participants().all().at(fleet.b.node->prefix()).endpoints;
  return known.contains(EntityId{{0x40, 0, 1, 7}});
}

TEST(ProvenRefreshes, ForgedAnnouncementsFromBefore_AreForgotten) {
  const Rules bare{.secure_topics = true};
  for (const auto& [before, after, secure] :
       {Case{bare, {.discovery = kSign, .secure_topics = true}, true},
        Case{bare, {.rtps = kSign, .secure_topics = true}, true},
        Case{{}, {.rtps = kSign}, false}}) {
    Fleet fleet(before);
    fleet.run(1);
    // The loop ends at the number of the first announcement that alice did not get yet.
    for (std::int64_t number = 2; number < 6 && !knows_forged(fleet); ++number) {
      auto data = *fleet.b.node->local_endpoints().find(fleet.readers.at(&fleet.b.node).entity);
      data.guid.entity.octets = {0x40, 0, 1, 7};
      const auto payload = serialized(data);
      fleet.a.node->receive(forged(fleet.b.node->prefix(),
                                   Data{secure ? kSubscriptionsSecureReader : kSubscriptionsReader,
                                        secure ? kSubscriptionsSecureWriter : kSubscriptionsWriter,
                                        {number},
                                        {},
                                        PayloadKind::data,
                                        payload}),
                            fleet.world.now, *Locator::parse("127.0.0.1", 0));
    }
    ASSERT_TRUE(knows_forged(fleet)) << fleet.text();
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, after, 2);
    fleet.run(14);
    EXPECT_EQ(fleet.a.node.events.count(Code::governance_renewed), 1) << fleet.text();
    EXPECT_FALSE(knows_forged(fleet)) << fleet.text();
    EXPECT_TRUE(fleet.has_all(fleet.b.node));
    EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0) << fleet.text();
    EXPECT_EQ(fleet.a.node.listener.matched, 2) << fleet.text();
  }
}

// ---- what participants announce of themselves

const Bytes kForgedText{'f', 'o', 'r', 'g', 'e', 'd'};

const RemoteParticipant& bob(Fleet& fleet) {
  return fleet.a.node->remote_participants().all().at(fleet.b.node->prefix());
}

// Announces in bob's name, by DCPSParticipantsSecure and without protection. The loop ends at the
// number of the first announcement that alice did not get yet.
void forge_bob(Fleet& fleet) {
  auto data = bob(fleet).data;
  data.user_data = kForgedText;
  data.metatraffic_unicast = data.default_unicast = {*Locator::parse("127.0.0.1", 7999)};
  Bytes buffer(4096);
  SpanWriter payload(buffer);
  write_payload(payload, data);
  for (std::int64_t number = 2; number < 6 && bob(fleet).data.user_data != kForgedText; ++number)
    fleet.a.node->receive(forged(fleet.b.node->prefix(), Data{kParticipantsSecureReader,
                                                              kParticipantsSecureWriter,
                                                              {number},
                                                              {},
                                                              PayloadKind::data,
                                                              payload.view()}),
                          fleet.world.now, *Locator::parse("127.0.0.1", 7999));
}

TEST(ProvenRefreshes, ForgedDataOfAParticipantFromBefore_GivesWayToItsOwn) {
  const Rules bare{.secure_topics = true};
  for (const auto& after : {Rules{.discovery = kSign, .secure_topics = true},
                            Rules{.rtps = kSign, .secure_topics = true}}) {
    Fleet fleet(bare);
    const Bytes own{'b', 'o', 'b'};
    fleet.b.node->change_own({.user_data = own}, fleet.world.now);
    fleet.run(1);
    ASSERT_EQ(bob(fleet).data.user_data, own);
    forge_bob(fleet);
    ASSERT_EQ(bob(fleet).data.user_data, kForgedText) << fleet.text();
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, after, 2);
    fleet.run(14);
    EXPECT_EQ(fleet.a.node.events.count(Code::governance_renewed), 1) << fleet.text();
    EXPECT_EQ(bob(fleet).data.user_data, own) << fleet.text();
    EXPECT_EQ(Fleet::unmatched(fleet.a.node), 0) << fleet.text();
  }
}

TEST(ProvenRefreshes, AddressesThatNothingProtects_AreNotTakenAsSigned) {
  Fleet fleet(Rules{.secure_topics = true});
  fleet.run(1);
  const auto addresses = bob(fleet).metatraffic;
  forge_bob(fleet);
  ASSERT_EQ(bob(fleet).data.user_data, kForgedText) << fleet.text();
  EXPECT_EQ(bob(fleet).metatraffic, addresses);
  EXPECT_EQ(bob(fleet).signed_metatraffic, addresses);
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
