// A participant that revises its keys without pause. Each revision is news for all endpoints of its
// peers, and for what they remember of its writers that have left.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(FrequentRevisions, KeysOfMessages_AreToldToEndpointsOnceASecond) {
  Trio trio(revising({.rtps = ProtectionKind::encrypt}));
  ASSERT_TRUE(trio.match()) << trio.text();
  auto& security = *ParticipantAccess::core(*trio.b.participant).security;
  const auto& of_alice = *security.core().find(trio.a->prefix())->state.association();
  bool any_untold = false;
  for (int i = 1; i <= 12; ++i) {
    ASSERT_TRUE(trio.a->revise_keys());
    ASSERT_TRUE(trio.world.run_until(
        [&] { return trio.a.events.count(Code::rtps_keys_revised) == i; }, 300));
    any_untold = any_untold || of_alice.is_revision_untold;
  }
  EXPECT_TRUE(any_untold);
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  trio.world.run(250);
  EXPECT_FALSE(of_alice.is_revision_untold);
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
}

}  // namespace
}  // namespace ddssec::rtps
