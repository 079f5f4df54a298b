// Warnings before the end of our own certificate and of its revocation list.
#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {
namespace {

using std::chrono::days;

// Alice alone, and what her plugin reports while days go by.
class Alone {
 public:
  explicit Alone(const Identity& identity) {
    const auto local = plugin_->validate_local_identity(0, identity.properties, candidate(1));
    EXPECT_TRUE(local);
    handle_ = local->handle;
  }
  // Returns the codes of the events of the next `count` days.
  std::vector<Code> live(int count) {
    plugin_.events.all.clear();
    for (int i = 0; i < count; ++i) {
      plugin_.clock.advance(days(1));
      plugin_->poll();
      plugin_->poll();
    }
    return plugin_.events.codes();
  }
  const std::vector<Event>& events() { return plugin_.events.all; }

 private:
  TestPlugin plugin_;
  IdentityHandle handle_;
};

Identity carol(days life) {
  return make_identity(test_ca(), "CN=carol,O=Example", {}, {kNow, kNow + life});
}

constexpr auto kSoon = Code::identity_ends_soon;

TEST(EndsSoon, Certificate_IsWarnedOfThirtySevenAndOneDayBefore) {
  Alone alone(carol(days(100)));
  EXPECT_TRUE(alone.live(69).empty());
  EXPECT_EQ(alone.live(1), std::vector{kSoon});
  const auto& event = alone.events().front();
  EXPECT_EQ(event.severity, Severity::warning);
  EXPECT_EQ(event.proof, PeerProof::not_a_peer);
  EXPECT_EQ(event.error.details().document, "CN=carol,O=Example");
  EXPECT_EQ(event.error.details().found, "2027-03-01T00:00:00Z, in 30 days");
  EXPECT_TRUE(alone.live(22).empty());
  EXPECT_EQ(alone.live(1), std::vector{kSoon});
  EXPECT_EQ(alone.live(6), std::vector{kSoon});
  EXPECT_EQ(alone.live(1), std::vector{Code::identity_ended});
}

TEST(EndsSoon, CaThatEndsFirst_IsWarnedOfThirtySevenAndOneDayBefore) {
  const auto ca = make_ca("CN=Short CA,O=Example", {}, {kNow - days(1), kNow + days(100)});
  Alone alone(make_identity(ca, "CN=carol,O=Example"));
  EXPECT_TRUE(alone.live(69).empty());
  for (const auto& [until, found] : {std::pair{1, "2027-03-01T00:00:00Z, in 30 days"},
                                     {23, "2027-03-01T00:00:00Z, in 7 days"},
                                     {6, "2027-03-01T00:00:00Z, in 1 day"}}) {
    EXPECT_EQ(alone.live(until), std::vector{kSoon});
    ASSERT_FALSE(alone.events().empty());
    EXPECT_EQ(alone.events().front().error.details().document, "CN=Short CA,O=Example");
    EXPECT_EQ(alone.events().front().error.details().found, found);
  }
  EXPECT_EQ(alone.live(1), std::vector{Code::identity_ended});
}

TEST(EndsSoon, Property_SaysWhen) {
  auto identity = carol(days(100));
  set(identity.properties, spi::property::kWarnBeforeEnd, "3");
  Alone alone(identity);
  EXPECT_TRUE(alone.live(96).empty());
  EXPECT_EQ(alone.live(3), std::vector{kSoon});

  set(identity.properties, spi::property::kWarnBeforeEnd, "0");
  EXPECT_TRUE(Alone(identity).live(99).empty());

  set(identity.properties, spi::property::kWarnBeforeEnd, "soon");
  TestPlugin plugin;
  EXPECT_CODE(plugin->validate_local_identity(0, identity.properties, candidate(1)),
              invalid_property);
}

TEST(EndsSoon, CertificateOfAWeek_IsWarnedOfOnItsLastDay) {
  Alone alone(carol(days(7)));
  EXPECT_TRUE(alone.live(5).empty());
  EXPECT_EQ(alone.live(1), std::vector{kSoon});
}

TEST(EndsSoon, RevocationList_IsWarnedOfUntilANewerOneIsThere) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("crl.pem", pem({.until = kNow + days(60)}));
  Alone alone(with_list(alice(), "file:" + path));
  EXPECT_TRUE(alone.live(40).empty());
  EXPECT_EQ(alone.live(13), std::vector{Code::crl_ends_soon});
  EXPECT_EQ(alone.events().front().error.details().document, path);
  EXPECT_EQ(alone.events().front().error.details().found, "2027-01-20T00:00:00Z, in 7 days");
  folder.replace("crl.pem", pem({.number = 2, .from = kNow, .until = kNow + days(120)}));
  EXPECT_EQ(alone.live(30), std::vector{Code::crl_renewed});
}

TEST(EndsSoon, PeersCertificate_IsNotOurs) {
  Pairing pairing(make_identity(test_ca(), "CN=alice,O=Example"),
                  make_identity(test_ca(), "CN=bob,O=Example", {}, {kNow, kNow + days(8)}, 1));
  pairing.expect_success();
  pairing.first_plugin.clock.advance(days(7) + 1h);
  EXPECT_TRUE(pairing.first_plugin->poll().empty());
  EXPECT_TRUE(pairing.first_plugin.events.all.empty());
}

}  // namespace
}  // namespace ddssec::authentication
