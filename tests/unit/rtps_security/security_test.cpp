// Participants and endpoints that part, and permissions that end.
#include "rtps/security/security.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

TEST(Joining, RemovedEndpointsAndParticipants_Part) {
  Pair pair(everything(kEncryptOa));
  ASSERT_TRUE(pair.match());
  pair.b->remove(pair.reader, pair.world.now);
  EXPECT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 0; }, 200));
  pair.a->leave();
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b->remote_participants().size() == 0; }, 200));
}

TEST(Joining, AnEndedPermission_EndsTheParticipation) {
  Pair pair(everything(kEncrypt));
  ASSERT_TRUE(pair.match());
  pair.b.clock.advance(std::chrono::hours(25));
  EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 0; }, 300));
}

// One subject has two grants, one after the other. The rights of the first grant end with it.
TEST(Joining, ANarrowerGrantThatFollows_IsInForceForWhatIsMatched) {
  const auto rules = everything(kEncrypt);
  auto bob = properties_of("CN=bob,O=Example", rules);
  governance::GrantRule rule;
  rule.allow = true;
  rule.domains.ranges = {{0, 230}};
  governance::Criteria criteria;
  criteria.topics = {{"Square", 0}};
  rule.publish = rule.subscribe = {criteria};
  governance::Grant first;
  first.name = "by day";
  first.subject_name = "CN=bob,O=Example";
  first.validity = {pki::kNow - 24h, pki::kNow + 1h};
  first.rules = {rule};
  auto next = first;
  next.validity = {pki::kNow, pki::kNow + 24h};
  next.rules[0].subscribe.clear();
  const auto xml = governance::to_xml(governance::Permissions{.grants = {first, next}});
  for (auto& property : bob)
    if (property.name == spi::property::kPermissions)
      property.value = data_uri(as_text(*Authorities::shared().permissions_ca.sign_document(
          as_bytes(xml), pki::kNow, pki::test_random())));
  Node a(1, properties_of("CN=alice,O=Example", rules)), b(2, bob);
  World world{{&a, &b}};
  const auto writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  ASSERT_TRUE(world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; }));
  a.clock.advance(1h);
  EXPECT_TRUE(world.run_until([&] { return a.listener.matched == 0; }, 300)) << a.events.text();
  // The peer returns, with the rights that it still has.
  EXPECT_TRUE(world.run_until([&] { return a.knows(b); })) << a.events.text();
  world.run(300);
  EXPECT_EQ(a.listener.matched, 0);
  EXPECT_TRUE(a.events.has(Code::announced_reader_not_allowed));
  EXPECT_TRUE(a->local_endpoints().matched(writer).empty());
}

}  // namespace
}  // namespace ddssec::rtps
