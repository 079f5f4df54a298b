// Insiders and outsiders misuse a governance change, above all its first phase, in which
// participants still accept the former protection.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/governance_changes.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

// The keys must not be revised at once, as if carol had lost her trust. This would end the first
// phase, and part alice and bob until bob has the document.
TEST(GovernanceChange, InsiderThatLeavesAndComesBack_DoesNotEndTheFirstPhase) {
  auto former = rules_of(ProtectionKind::sign, ProtectionKind::sign);
  auto next = rules_of(ProtectionKind::encrypt, ProtectionKind::encrypt);
  former.revises_keys = next.revises_keys = true;
  Fleet fleet(former, "60");
  auto &a = fleet.a.node, &b = fleet.b.node;
  fleet.put({&fleet.a}, next, 2);
  fleet.run(4);
  fleet.c.node->leave();
  ASSERT_TRUE(fleet.world.run_until([&] { return a->remote_participants().size() == 1; }, 300));
  Node again(3, fleet.c.properties("carol", former, "60"), fleet.c.node);
  ASSERT_EQ(again->prefix(), fleet.c.node->prefix());
  fleet.world.nodes = {&a, &b, &again};
  ASSERT_TRUE(fleet.world.run_until([&] { return a.knows(again); }, 3000)) << fleet.text();
  fleet.run(20);
  EXPECT_EQ(Fleet::unmatched(b), 0) << fleet.text();
  EXPECT_TRUE(fleet.has_all(b)) << fleet.text();
  fleet.put({&fleet.b}, next, 2);
  fleet.run(10);
  EXPECT_EQ(Fleet::unmatched(b), 0) << fleet.text();
  EXPECT_TRUE(fleet.has_all(b)) << fleet.text();
}

// An insider makes bob revise his keys all the time, and the others change meanwhile.
TEST(GovernanceChange, RevisionsOfOneParticipant_LeaveItTheKeysOfTheOthers) {
  const auto former = revising(everything(kSign)), next = revising(everything(kEncrypt));
  Fleet fleet(former, "60");
  fleet.put({&fleet.a, &fleet.b}, next, 2);
  fleet.run(4);
  ASSERT_TRUE(fleet.b.node.events.has(Code::governance_changing)) << fleet.text();
  fleet.put({&fleet.c}, next, 2);
  const auto has_all = [&] { return fleet.b.node.listener.changes.size() == fleet.written; };
  for (int second = 0; second < 12; ++second) {
    for (auto* node : fleet.world.nodes) node->clock.advance(1s);
    for (int i = 0; i < 10; ++i) {
      EXPECT_TRUE(fleet.b.node->revise_keys());
      fleet.write();
      fleet.world.run(10);
    }
    EXPECT_TRUE(fleet.world.run_until(has_all, 20)) << second << fleet.text();
  }
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  EXPECT_TRUE(fleet.c.node.events.has(Code::governance_renewed)) << fleet.text();
  fleet.run(10);
  EXPECT_TRUE(fleet.b.node.events.has(Code::governance_renewed)) << fleet.text();
  for (auto* member : {&fleet.a, &fleet.b, &fleet.c})
    EXPECT_EQ(Fleet::unmatched(member->node), 0) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

// Returns true if bob takes a new sample in alice's name that was made with her former keys, as a
// former reader of hers can make it.
bool takes_sample_under_former_keys(Fleet& fleet) {
  auto &a = fleet.a.node, &b = fleet.b.node;
  EXPECT_TRUE(fleet.has_all(b)) << fleet.text();
  auto& core = ParticipantAccess::core(*a.participant);
  auto& phases = core.security->keyring().phases();
  a.post.sent.clear();
  phases.swap();
  fleet.write();
  core.sender.flush_now();
  phases.swap();
  const auto before = b.listener.changes.size();
  EXPECT_FALSE(a.post.sent.empty());
  for (const auto& [port, datagram] : std::exchange(a.post.sent, {}))
    if (port == b.port) b->receive(datagram, fleet.world.now, *Locator::parse("127.0.0.1", 0));
  return b.listener.changes.size() > before;
}

TEST(GovernanceChange, KeysOfTheFormerProtection_CountNoMoreOnceTheirOwnerHasChanged) {
  const std::pair<Rules, Rules> changes[] = {
      {{.metadata = kSign}, {.metadata = kEncrypt}},
      {rules_of(kNone, kNone, kSign), rules_of(kNone, kNone, kEncrypt)},
      {rules_of(kNone, kSign, kEncrypt), rules_of(kNone, kEncrypt, kEncrypt)}};
  for (const auto& [former, next] : changes) {
    SecondPhase fleet(former, next);
    const auto dropped = fleet.b.node->protection_counters().undecodable;
    EXPECT_FALSE(takes_sample_under_former_keys(fleet)) << fleet.text();
    EXPECT_GT(fleet.b.node->protection_counters().undecodable, dropped);
    EXPECT_TRUE(fleet.has_all(fleet.b.node)) << "the true one comes" << fleet.text();
    EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0) << fleet.text();
  }
}

// ---- an outsider, where discovery and messages are bare

// Returns a message without protection that says that the endpoint has ended.
Bytes forged_end(const Guid& endpoint, std::int64_t number) {
  const bool writes = is_writer(endpoint.entity);
  return forged(endpoint.prefix, Data{writes ? kPublicationsReader : kSubscriptionsReader,
                                      writes ? kPublicationsWriter : kSubscriptionsWriter,
                                      {number},
                                      {endpoint.octets(), {true, true}},
                                      PayloadKind::none,
                                      {}});
}

// Forges the end of alice's writer at bob. Alice does not notice, and sends no keys again.
void part(Fleet& fleet, const Guid& reader) {
  for (std::int64_t number = 1; number < 6; ++number)
    fleet.b.node->receive(forged_end(fleet.writer, number), fleet.world.now,
                          *Locator::parse("127.0.0.1", 7999));
  EXPECT_TRUE(fleet.b.node->local_endpoints().matched(reader).empty());
}

enum class When { before_the_document, in_the_first_phase };

void expect_that_they_match_after_the_change(const Rules& before, const Rules& after, When when) {
  Fleet fleet(before, "60");
  // Alice expects no answer of this reader, so she does not notice that it is parted, and sends no
  // keys for that reason.
  auto& bob = fleet.b.node;
  Listener silent;
  bob->remove(fleet.readers.at(&bob), fleet.world.now);
  const auto reader =
      bob->create_reader(square(default_reader_qos()), silent, fleet.world.now).value();
  ASSERT_TRUE(fleet.world.run_until([&] { return silent.matched == 1; })) << fleet.text();
  fleet.run(1);
  if (when == When::before_the_document) part(fleet, reader);
  fleet.put({&fleet.a, &fleet.b}, after, 2);
  fleet.run(4);
  ASSERT_TRUE(fleet.a.node.events.has(Code::governance_changing)) << fleet.text();
  if (when == When::in_the_first_phase) part(fleet, reader);
  fleet.run(12);
  ASSERT_FALSE(bob.events.has(Code::governance_renewed)) << "carol is waited for";
  EXPECT_EQ(silent.matched, 1) << "by the former protection" << fleet.text();
  fleet.put({&fleet.c}, after, 2);
  fleet.run(10);
  EXPECT_TRUE(fleet.a.node.events.has(Code::governance_renewed)) << fleet.text();
  EXPECT_EQ(fleet.a.node.listener.matched, 2) << fleet.text();
  EXPECT_EQ(silent.matched, 1) << fleet.text();
  const auto received = silent.changes.size();
  fleet.run(1);
  fleet.world.run(100);
  EXPECT_EQ(silent.changes.size(), received + 10) << fleet.text();
}

// The keys of the next protection are sent only once, as those of the present one are.
TEST(GovernanceChange, ForgedEndOfAnEndpoint_TakesNoKeysOfTheNextProtection) {
  // The liveliness of the domain changes, too, so bob waits for carol.
  const Rules bare, signs{.metadata = kSign}, next_signs{.liveliness = kSign, .metadata = kSign},
      next_encrypts{.liveliness = kSign, .metadata = kEncrypt};
  for (const auto when : {When::before_the_document, When::in_the_first_phase}) {
    expect_that_they_match_after_the_change(signs, next_encrypts, when);
    expect_that_they_match_after_the_change(bare, next_signs, when);
  }
}

// The announcements that protection proves count, whatever was said before.
TEST(GovernanceChange, ForgedEndsOfManyEndpointsFromBefore_PartNoneAfterIt) {
  const Rules bare{.metadata = kSign};
  auto discovery = bare, messages = bare;
  discovery.discovery = messages.rtps = kSign;
  for (const auto& after : {discovery, messages}) {
    Fleet fleet(bare, "60", false);
    auto &a = fleet.a.node, &b = fleet.b.node;
    std::vector<Guid> readers{fleet.readers.at(&b)};
    while (readers.size() < AnnouncementRefresh::kMaxEnded + 20)
      readers.push_back(
          b->create_reader(square(default_reader_qos()), b.listener, fleet.world.now).value());
    const auto all = static_cast<int>(readers.size());
    ASSERT_TRUE(fleet.world.run_until([&] { return a.listener.matched == all; }, 1000));
    fleet.put({&fleet.a, &fleet.b}, after, 2);
    for (auto* node : fleet.world.nodes) node->clock.advance(1s);
    std::int64_t number = all;
    for (const auto& reader : readers)
      a->receive(forged_end(reader, ++number), fleet.world.now, *Locator::parse("127.0.0.1", 7999));
    EXPECT_EQ(a.listener.matched, all - static_cast<int>(AnnouncementRefresh::kMaxEnded));
    fleet.run(20);
    EXPECT_TRUE(a.events.has(Code::governance_renewed)) << fleet.text();
    EXPECT_EQ(a.listener.matched, all) << fleet.text();
    EXPECT_EQ(a.listener.unmatched, static_cast<int>(AnnouncementRefresh::kMaxEnded));
  }
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
