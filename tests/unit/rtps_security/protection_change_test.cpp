// Endpoints while the governance protects their topic more.
#include "rtps/participant/protection_change.hpp"

#include "tests/support/expect_code.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/governance_changes.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::governance_changes {
namespace {

using namespace testing;

TEST(GovernanceChange, EndpointsMadeMeanwhile_MatchAndKeepTheirSamples) {
  Fleet fleet(rules_of(kSign, kSign));
  fleet.put({&fleet.a, &fleet.b}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(4);  // carol is waited for
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

TEST(GovernanceChange, WithoutTimeToWait_TheNewProtectionCountsAtOnce) {
  Fleet fleet(rules_of(kSign, kSign), "0");
  fleet.put({&fleet.a}, rules_of(kEncrypt, kEncrypt), 2);
  fleet.run(4);
  EXPECT_EQ(fleet.a.node.listener.matched, 0) << fleet.text();
  EXPECT_FALSE(fleet.is_readable_on_the_network());
}

}  // namespace
}  // namespace ddssec::rtps::governance_changes
