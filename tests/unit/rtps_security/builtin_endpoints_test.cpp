// The builtin topic on which liveliness is asserted.
#include "rtps/participant/builtin_endpoints.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kNone = ProtectionKind::none;
constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(Joining, Liveliness_IsAssertedOnTheRightTopic) {
  for (auto kind : {kNone, kEncrypt}) {
    Pair pair({.liveliness = kind});
    auto qos = default_writer_qos();
    qos.liveliness.lease_duration = Duration{{1, 0}};
    ASSERT_TRUE(pair.a->create_writer(square(qos), pair.a.listener, pair.world.now));
    auto requested = default_reader_qos();
    requested.liveliness.lease_duration = Duration{{1, 0}};
    ASSERT_TRUE(pair.b->create_reader(square(requested), pair.b.listener, pair.world.now));
    ASSERT_TRUE(pair.world.run_until([&] { return pair.b.listener.matched == 1; }));
    pair.world.run(100);
    const auto before = pair.b.listener.alive;
    pair.world.run(400);
    EXPECT_GE(pair.b.listener.alive - before, 4);
  }
}

}  // namespace
}  // namespace ddssec::rtps
