// A participant leaves in order, under governance that protects discovery and under others.
#include "rtps/security/leaving.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(Leaving, UnderAnyGovernance_IsNoticedAtOnce) {
  for (const auto& rules : {Rules{}, Rules{.data = kEncrypt}, Rules{.metadata = kEncrypt},
                            Rules{.discovery = kEncrypt}, everything(kEncrypt)}) {
    Pair pair(rules);
    ASSERT_TRUE(pair.match()) << pair.a.events.text();
    pair.b->leave();
    pair.world.run(1);
    EXPECT_FALSE(pair.a.knows(pair.b));
    EXPECT_EQ(pair.a.listener.matched, 0);
    pair.world.nodes = {&pair.a};
    pair.world.run(300);
    EXPECT_TRUE(pair.a->remote_participants().all().empty());
  }
}

// Only the report on the volatile secure channel is sent, no dispose.
TEST(Leaving, TheReportAlone_IsEnough) {
  Pair pair({.data = kEncrypt});
  ASSERT_TRUE(pair.match()) << pair.a.events.text();
  pair.world.run(200);
  auto& security = *const_cast<ParticipantCore&>(pair.b->remote_participants().core()).security;
  announce_leaving(security.core(), security.exchange());
  security.core().sender.flush();
  EXPECT_EQ(pair.b.post.sent.size(), 1u);
  pair.world.run(1);
  EXPECT_FALSE(pair.a.knows(pair.b));
}

// A participant that goes on after its report is a stranger, and authenticates again.
TEST(Leaving, AParticipantThatStays_ComesBack) {
  Pair pair({.data = kEncrypt});
  ASSERT_TRUE(pair.match()) << pair.a.events.text();
  pair.b->leave();
  pair.world.run(1);
  ASSERT_FALSE(pair.a.knows(pair.b));
  EXPECT_TRUE(pair.world.run_until([&] { return pair.a.knows(pair.b); }, 3000))
      << pair.a.events.text() << pair.b.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
