// Endpoints and their announcements while the governance protects them more.
#include "rtps/participant/protection_change.hpp"

#include "rtps/discovery/serialized.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/governance_changes.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

TEST(GovernanceChange, EndpointsMadeMeanwhile_MatchAndKeepTheirSamples) {
  Fleet fleet(rules_of(kSign, kSign));
  fleet.put({&fleet.a, &fleet.b}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(4);  // the others wait for carol
  auto reading = default_reader_qos();
  reading.reliability.kind = ReliabilityKind::reliable;
  reading.history.kind = HistoryKind::keep_all;
  Listener late;
  ASSERT_TRUE(fleet.b.node->create_reader(square(reading), late, fleet.world.now));
  ASSERT_TRUE(fleet.world.run_until([&] { return late.matched == 1; })) << fleet.text();
  const auto before = fleet.written;
  fleet.run(2);
  fleet.put({&fleet.c}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(8);
  EXPECT_TRUE(
      fleet.world.run_until([&] { return late.changes.size() == fleet.written - before; }, 3000))
      << late.changes.size() << " of " << fleet.written - before << fleet.text();
  EXPECT_TRUE(fleet.c.node.events.has(Code::governance_renewed));
  EXPECT_EQ(late.unmatched, 0);
  EXPECT_TRUE(fleet.has_all(fleet.c.node))
      << fleet.c.node.listener.changes.size() << " of " << fleet.written << fleet.text();
}

// Results of a filter would tell what an encrypted payload holds. Carol has the document, but does
// not announce her reader again, because nothing is heard of her any more.
TEST(GovernanceChange, FilterOfAReader_EndsWhenPayloadsAreEncrypted) {
  for (const auto kind : {kSign, kEncrypt}) {
    Fleet fleet(rules_of(kNone, kNone), "4");
    fleet.a.node.listener.filter = std::make_shared<FixedFilter>(true);
    auto description = square(default_reader_qos());
    description.content_filter = ContentFilterProperty{
        .content_filtered_topic_name = "Few", .related_topic_name = "Square", .filter = {"x = 1"}};
    Listener filtered;
    ASSERT_TRUE(fleet.c.node->create_reader(description, filtered, fleet.world.now));
    const auto& readers = fleet.a.node->local_endpoints().writer(fleet.writer)->readers();
    ASSERT_TRUE(fleet.world.run_until([&] { return readers.filtered() == 1; }));
    MonotonicTime mute_from = kNever;
    fleet.world.filter = [&](const Node& from, Bytes datagram) {
      const bool is_mute = &from == &fleet.c.node && fleet.world.now > mute_from;
      return is_mute ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules_of(kind, kind), 2);
    for (int i = 0; i < 10 && !fleet.a.node.events.has(Code::governance_renewed); ++i) {
      fleet.run(1);
      if (fleet.c.node.events.has(Code::governance_changing))
        mute_from = std::min(mute_from, fleet.world.now);
    }
    EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
    EXPECT_EQ(readers.filtered(), kind == kEncrypt ? 0u : 1u) << fleet.text();
  }
}

TEST(GovernanceChange, WithoutTimeToWait_TheNewProtectionCountsAtOnce) {
  Fleet fleet(rules_of(kSign, kSign), "0");
  fleet.put({&fleet.a}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(4);
  EXPECT_EQ(fleet.a.node.listener.matched, 0) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

// ---- discovery, liveliness and flags

struct Change {
  std::string_view name;
  Rules before, after;
};

std::ostream& operator<<(std::ostream& out, const Change& change) { return out << change.name; }

Rules discovery(ProtectionKind kind, bool secure_topics = true) {
  return {.discovery = kind, .clear_topics = !secure_topics, .secure_topics = secure_topics};
}
Rules liveliness(ProtectionKind kind) { return {.liveliness = kind}; }

constexpr auto kSignOrigin = ProtectionKind::sign_with_origin_authentication,
               kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

Qos reliable() {
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.history.kind = HistoryKind::keep_all;
  return qos;
}

const EndpointData& reader_of(Fleet& fleet, Member& member) {
  return *member.node->local_endpoints().find(fleet.readers.at(&member.node).entity);
}

void expect_taken(Fleet& fleet, int times = 1) {
  EXPECT_TRUE(fleet.has_all(fleet.b.node))
      << fleet.b.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.c.node))
      << fleet.c.node.listener.changes.size() << " of " << fleet.written << fleet.text();
  for (const auto* member : {&fleet.a, &fleet.b, &fleet.c}) {
    EXPECT_EQ(member->node.events.count(Code::governance_renewed), times) << fleet.text();
    EXPECT_EQ(Fleet::unmatched(member->node), 0) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::rtps_security_info_mismatch)) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::rtps_protection_missing)) << fleet.text();
    EXPECT_FALSE(member->node.events.has(Code::governance_peer_behind)) << fleet.text();
  }
}

// A reader that comes and goes is found and lost by all.
void expect_found_and_lost(Fleet& fleet) {
  Listener late;
  const auto reader = fleet.b.node->create_reader(square(reliable()), late, fleet.world.now);
  ASSERT_TRUE(reader);
  EXPECT_TRUE(fleet.world.run_until([&] { return late.matched == 1; }, 500)) << fleet.text();
  EXPECT_TRUE(fleet.world.run_until([&] { return fleet.a.node.listener.matched == 3; }, 500));
  fleet.b.node->remove(*reader, fleet.world.now);
  EXPECT_TRUE(fleet.world.run_until([&] { return fleet.a.node.listener.matched == 2; }, 500))
      << fleet.text();
}

// The readers of the fleet go, too, though they were announced before the change.
void expect_announced_no_more(Fleet& fleet) {
  for (auto* node : {&fleet.b.node, &fleet.c.node})
    (*node)->remove(fleet.readers.at(node), fleet.world.now);
  EXPECT_TRUE(fleet.world.run_until([&] { return fleet.a.node.listener.matched == 0; }, 500))
      << fleet.a.node.listener.matched << fleet.text();
}

class DomainProtection : public ::testing::TestWithParam<Change> {};

TEST_P(DomainProtection, RunningTraffic_LosesNothingAndNoMatch) {
  Fleet fleet(GetParam().before);
  fleet.run(3);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, GetParam().after, 2);
  fleet.run(12);
  expect_taken(fleet);
  expect_found_and_lost(fleet);
  expect_announced_no_more(fleet);
}

TEST_P(DomainProtection, OnALossyNetwork_LosesNothingAndNoMatch) {
  Fleet fleet(GetParam().before);
  fleet.is_lossy = true;
  fleet.run(2);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, GetParam().after, 2);
  fleet.run(20);
  expect_taken(fleet);
  fleet.is_lossy = false;
  expect_found_and_lost(fleet);
}

// If its discovery changes, the reader is removed while both discoveries announce it.
TEST_P(DomainProtection, AReaderRemovedMeanwhile_IsGoneForAll) {
  Fleet fleet(GetParam().before);
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, GetParam().after, 2);
  const auto& reader = reader_of(fleet, fleet.b);
  const auto before = reader.security_info;
  for (int i = 0; i < 300 && reader.security_info == before; ++i) {
    if (i % 100 == 0)
      for (auto* node : fleet.world.nodes) node->clock.advance(1s);
    fleet.world.run(1);
  }
  EXPECT_TRUE(fleet.b.node.events.has(Code::governance_changing)) << fleet.text();
  expect_announced_no_more(fleet);
  fleet.run(10);
  EXPECT_EQ(fleet.a.node.listener.matched, 0) << fleet.text();
}

INSTANTIATE_TEST_SUITE_P(
    Discovery, DomainProtection,
    ::testing::Values(Change{"raised", discovery(kNone), discovery(kSign)},
                      Change{"encrypted", discovery(kSign), discovery(kEncrypt)},
                      Change{"with origin", discovery(kSignOrigin), discovery(kEncryptOrigin)},
                      Change{"topics secure", discovery(kSign, false), discovery(kSign)},
                      Change{"all secure", discovery(kNone, false), discovery(kEncrypt)}));

INSTANTIATE_TEST_SUITE_P(Liveliness, DomainProtection,
                         ::testing::Values(Change{"raised", liveliness(kNone), liveliness(kSign)},
                                           Change{"encrypted", liveliness(kSign),
                                                  liveliness(kEncrypt)}));

INSTANTIATE_TEST_SUITE_P(Flags, DomainProtection,
                         ::testing::Values(Change{"controlled", {.open_topics = true}, {}},
                                           Change{"everything", {}, everything(kEncrypt)}));

TEST(DomainProtectionChange, StepByStep_AllAreTaken) {
  Fleet fleet(discovery(kNone, false));
  std::uint32_t revision = 1;
  for (const auto& rules : {discovery(kSign, false), discovery(kSign), discovery(kEncrypt)}) {
    fleet.put({&fleet.a, &fleet.b, &fleet.c}, rules, ++revision);
    fleet.run(10);
  }
  expect_taken(fleet, 3);
  expect_found_and_lost(fleet);
  expect_announced_no_more(fleet);
}

// True if a new reader of that topic is named on the network.
bool is_announced_in_the_clear(Fleet& fleet, const std::string& topic) {
  fleet.sent.clear();
  fleet.watches = true;
  Listener listener;
  const auto reader = fleet.b.node->create_reader({topic, "ShapeType", reliable(), true}, listener,
                                                  fleet.world.now);
  EXPECT_TRUE(reader);
  fleet.run(1);
  fleet.b.node->remove(*reader, fleet.world.now);
  fleet.run(1);
  fleet.watches = false;
  return std::ranges::any_of(fleet.sent, [&](const Bytes& datagram) {
    return as_text(datagram).find(topic) != std::string_view::npos;
  });
}

TEST(DomainProtectionChange, AnnouncementsWithNames_AreHiddenAsTheDocumentInForceDemands) {
  Fleet fleet(discovery(kEncrypt, false));
  EXPECT_TRUE(is_announced_in_the_clear(fleet, "No secret"));
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, discovery(kEncrypt), 2);
  fleet.run(8);
  EXPECT_FALSE(is_announced_in_the_clear(fleet, "One secret"));
  expect_taken(fleet);
}

TEST(DomainProtectionChange, APeerThatStaysBehind_PartsAndComesBackWithTheDocument) {
  for (const auto& [before, after] : {std::pair(discovery(kSign), discovery(kEncrypt)),
                                      std::pair(liveliness(kNone), liveliness(kSign))}) {
    Fleet fleet(before, "10");
    fleet.put({&fleet.a, &fleet.b}, after, 2);
    fleet.run(6);
    EXPECT_EQ(fleet.c.node.listener.matched, 1);
    fleet.run(40);
    EXPECT_EQ(fleet.c.node.listener.matched, 0) << fleet.text();
    EXPECT_TRUE(fleet.a.node.events.has(Code::governance_peer_behind)) << fleet.text();
    EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
    EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0);
    fleet.put({&fleet.c}, after, 2);
    fleet.run(20);
    EXPECT_EQ(fleet.c.node.listener.matched, 1) << fleet.text();
  }
}

// Bob's time is over before alice's is, because he has waited longer for carol.
TEST(DomainProtectionChange, APeerThatChangesLater_IsHeardMeanwhile) {
  for (const auto& [before, after] : {std::pair(liveliness(kNone), liveliness(kSign)),
                                      std::pair(Rules{}, Rules{.rtps = kSign})}) {
    Fleet fleet(before, "10");
    auto qos = default_writer_qos();
    qos.liveliness.lease_duration = Duration{{1, 0}};
    Listener heard;
    ASSERT_TRUE(fleet.a.node->create_writer({"Circle", "ShapeType", qos, true},
                                            fleet.a.node.listener, fleet.world.now));
    auto reading = default_reader_qos();
    reading.liveliness.lease_duration = Duration{{1, 0}};
    ASSERT_TRUE(fleet.b.node->create_reader({"Circle", "ShapeType", reading, true}, heard,
                                            fleet.world.now));
    fleet.put({&fleet.b}, after, 2);
    fleet.run(5);
    fleet.put({&fleet.a}, after, 2);
    for (int second = 0; second < 12; ++second) {
      const auto alive = heard.alive;
      fleet.run(1);
      EXPECT_GT(heard.alive, alive) << second << fleet.text();
      EXPECT_TRUE(fleet.has_all(fleet.b.node)) << second << fleet.text();
    }
    EXPECT_EQ(heard.unmatched, 0);
    EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed));
  }
}

// ---- attackers

// Returns a clear announcement of bob's reader that names another topic.
Bytes forged_announcement(Fleet& fleet, std::int64_t number, bool ends) {
  auto data = reader_of(fleet, fleet.b);
  data.topic_name = "Circle";
  const auto payload = serialized(data);
  Data message{
      kSubscriptionsReader, kSubscriptionsWriter, {number}, {}, PayloadKind::data, payload};
  if (ends) {
    message.inline_qos = {data.guid.octets(), {true, true}};
    message.kind = PayloadKind::none;
    message.payload = {};
  }
  return forged(fleet.b.node->prefix(), message);
}

// Forges at any time of a change. Once the secure announcement has come, no clear one changes what
// alice knows of the reader.
void expect_secure_announcement_stays(const Rules& before, const Rules& after, bool ends) {
  Fleet fleet(before);
  std::int64_t number = 100;
  bool was_secure = false;
  fleet.put({&fleet.a, &fleet.b, &fleet.c}, after, 2);
  for (int i = 0; i < 120; ++i) {
    if (i % 10 == 0)
      for (auto* node : fleet.world.nodes) node->clock.advance(1s);
    const auto& known =
        fleet.a.node->remote_participants().all().at(fleet.b.node->prefix()).endpoints;
    const auto reader = known.find(fleet.readers.at(&fleet.b.node).entity);
    if (was_secure) {
      ASSERT_NE(reader, known.end()) << i << fleet.text();
      EXPECT_TRUE(reader->second.data.by_secure_discovery) << i;
      EXPECT_EQ(reader->second.data.topic_name, "Square") << i;
    } else if (reader != known.end() && reader->second.data.by_secure_discovery) {
      EXPECT_EQ(reader->second.data.topic_name, "Square") << i;
      was_secure = true;
    }
    // The first numbers are those that alice waits for.
    for (std::int64_t at = 1; was_secure && at < 8; ++at)
      fleet.a.node->receive(forged_announcement(fleet, at == 7 ? ++number : at, ends),
                            fleet.world.now, *Locator::parse("127.0.0.1", 0));
    fleet.write();
    fleet.world.run(10);
  }
  EXPECT_TRUE(was_secure);
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.a.node), 0) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.b.node));
}

TEST(DomainProtectionChange, ForgedClearAnnouncements_NeverTakeThePlaceOfASecureOne) {
  for (const bool ends : {false, true}) {
    expect_secure_announcement_stays(discovery(kSign, false), discovery(kSign), ends);
    expect_secure_announcement_stays(discovery(kSign), discovery(kEncrypt), ends);
  }
}

// Forges secure announcements of the sender without any protection. One of their numbers is the
// next one of the sender. Returns true if alice knows the reader then.
bool takes_secure_announcement(Fleet& fleet, const GuidPrefix& sender) {
  auto data = reader_of(fleet, fleet.b);
  data.guid = {sender, EntityId{{0x40, 0, 1, 7}}};
  const auto payload = serialized(data);
  for (std::int64_t number = 1; number < 6; ++number)
    fleet.a.node->receive(forged(sender, Data{kSubscriptionsSecureReader,
                                              kSubscriptionsSecureWriter,
                                              {number},
                                              {},
                                              PayloadKind::data,
                                              payload}),
                          fleet.world.now, *Locator::parse("127.0.0.1", 0));
  return fleet.a.node->remote_participants().all().at(sender).endpoints.contains(data.guid.entity);
}

// The discovery of the domain becomes signed.
TEST(DomainProtectionChange, ForgedSecureAnnouncement_CountsNoMoreOnceItsSenderHasChanged) {
  {
    Fleet fleet(discovery(kNone));
    fleet.run(1);
    EXPECT_TRUE(takes_secure_announcement(fleet, fleet.b.node->prefix())) << "nothing protects it";
  }
  SecondPhase fleet(discovery(kNone), discovery(kSign));
  const auto dropped = fleet.a.node->protection_counters().unprotected;
  EXPECT_FALSE(takes_secure_announcement(fleet, fleet.b.node->prefix()));
  EXPECT_EQ(fleet.a.node->protection_counters().unprotected, dropped + 5);
  EXPECT_TRUE(takes_secure_announcement(fleet, fleet.c.node->prefix())) << "she may send so";
}

// ---- liveliness

// Returns an assertion without any protection. Its number is above all numbers of the sender.
Bytes clear_assertion(const GuidPrefix& sender) {
  KeyHash key{};
  std::ranges::copy(sender.octets, key.begin());
  key.back() = 1;  // automatic
  Bytes body{0, 1, 0, 0};
  body.insert(body.end(), key.begin(), key.end());
  body.insert(body.end(), {1, 0, 0, 0, 0, 0, 0, 0});
  return forged(sender, Data{kParticipantMessageReader,
                             kParticipantMessageWriter,
                             {1'000'000},
                             {},
                             PayloadKind::data,
                             body});
}

struct Heard {
  Heard(Fleet& fleet, Member& writes) : fleet(fleet), writes(writes) {
    auto qos = default_writer_qos();
    qos.liveliness.lease_duration = Duration{{3, 0}};
    EXPECT_TRUE(
        writes.node->create_writer({"Circle", "ShapeType", qos, true}, writing, fleet.world.now));
    auto reading = default_reader_qos();
    reading.liveliness.lease_duration = Duration{{3, 0}};
    EXPECT_TRUE(fleet.b.node->create_reader({"Circle", "ShapeType", reading, true}, listener,
                                            fleet.world.now));
    EXPECT_TRUE(fleet.world.run_until([&] { return listener.matched == 1; }, 300));
  }
  bool takes_clear_assertion() {
    const auto before = listener.alive;
    fleet.b.node->receive(clear_assertion(writes.node->prefix()), fleet.world.now,
                          *Locator::parse("127.0.0.1", 0));
    return listener.alive > before;
  }
  Fleet& fleet;
  Member& writes;
  Listener listener, writing;
};

TEST(DomainProtectionChange, ForgedClearAssertion_CountsNoMoreOnceItsSenderHasChanged) {
  {
    Fleet fleet(liveliness(kNone));
    Heard heard(fleet, fleet.a);
    EXPECT_TRUE(heard.takes_clear_assertion()) << "nothing protects it";
  }
  {
    Fleet fleet(liveliness(kNone));
    Heard heard(fleet, fleet.a);
    fleet.put({&fleet.a, &fleet.b}, liveliness(kSign), 2);
    fleet.run(4);
    EXPECT_TRUE(heard.takes_clear_assertion()) << "carol is waited for";
  }
  SecondPhase fleet(liveliness(kNone), liveliness(kSign));
  Heard heard(fleet, fleet.a);
  EXPECT_FALSE(heard.takes_clear_assertion()) << fleet.text();
  fleet.run(12);
  EXPECT_FALSE(heard.takes_clear_assertion()) << fleet.text();
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
