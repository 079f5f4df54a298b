// Memory fails at any moment while a revoked certificate is looked up. The certificate is still
// found, later. This is a program of its own because it replaces malloc and operator new.
#include <new>

#include "tests/support/failing_memory.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

using failing_memory::Extent;
using failing_memory::Source;

// Bob has authenticated, and then Alice's list names him.
struct Scene {
  Scene() : pairing(alice(), bob()) {
    pairing.expect_success();
    put({bob().certificate}, 2);
  }
  const Identity& bob() {
    static const auto identity = make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1);
    return identity;
  }
  Identity alice() {
    put({}, 1);
    static const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
    auto ours = identity;
    set(ours.properties, spi::property::kCrl, "file:" + folder.path() + "/crl.pem");
    return ours;
  }
  void put(const std::vector<pki::Certificate>& revoked, std::uint64_t number) {
    const pki::CrlTemplate content{.revoked = revoked,
                                   .this_update = kNow - 1h,
                                   .next_update = kYear.not_after,
                                   .number = number};
    folder.replace("crl.pem", test_ca().make_crl(content)->pem());
  }
  // Polls after five seconds, as a host does.
  std::size_t poll() {
    pairing.first_plugin.clock.advance(5s);
    try {
      return pairing.first_plugin->poll().size();
    } catch (const std::bad_alloc&) {
      return 0;
    }
  }

  const test::TemporaryFolder folder;
  Pairing pairing;
};

class AuthenticationOutOfMemory : public testing::TestWithParam<std::tuple<Source, Extent>> {};
INSTANTIATE_TEST_SUITE_P(All, AuthenticationOutOfMemory,
                         testing::Combine(testing::ValuesIn(failing_memory::sources()),
                                          testing::Values(Extent::once, Extent::from_then_on)));

TEST_P(AuthenticationOutOfMemory, FailingAllocation_DelaysARevocationAndLosesNone) {
  const auto [source, extent] = GetParam();
  long number = 0;
  for (bool failed = true; failed;) {
    Scene scene;
    failing_memory::fail_at(source, extent, ++number);
    std::size_t ended = scene.poll();
    failed = failing_memory::stop_failing();
    for (int i = 0; i < 3; ++i) ended += scene.poll();
    EXPECT_EQ(ended, 1u) << "allocation " << number;
    EXPECT_FALSE(scene.pairing.a.discover(scene.pairing.b)) << "allocation " << number;
  }
  EXPECT_GT(number, 10);
}

}  // namespace
}  // namespace ddssec::authentication
