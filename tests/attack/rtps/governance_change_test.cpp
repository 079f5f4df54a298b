// An insider tries to end the first phase of a governance change, in which participants still
// accept the former protection, before all of them have the document.
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

}  // namespace
}  // namespace ddssec::rtps::governance_changes
