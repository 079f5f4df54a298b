// A certificate without rights to any of our topics, and as many participants with it as its owner
// likes.
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Participants of one certificate that send to `victim` only, and then never again.
class Insiders {
 public:
  explicit Insiders(Node& victim) : victim_(victim) {}

  // Returns true if one more has authenticated within a second.
  bool join(MonotonicTime& now) {
    auto insider = make(++count_);
    for (int step = 0; step < 100; ++step, now += milliseconds(10)) {
      for (auto& [port, octets] : std::exchange(insider->post.sent, {}))
        if (port == victim_.port) victim_->receive(octets, now);
      for (auto& [port, octets] : std::exchange(victim_.post.sent, {}))
        if (port == port_of(count_)) insider->participant->receive(octets, now);
      victim_->tick(now);
      insider->participant->tick(now);
      if (victim_->is_authenticated(insider->participant->prefix())) return true;
    }
    return false;
  }

 private:
  struct Insider {
    Node::Post post;
    std::unique_ptr<RtpsParticipant> participant;
  };
  static std::uint32_t port_of(std::uint32_t number) { return 20'000 + number; }

  std::unique_ptr<Insider> make(std::uint32_t number) {
    auto own = OwnSecurity::create(
        {{*plugins_.authentication, *plugins_.access_control, *plugins_.cryptography}, properties_},
        0, fake_prefix(number));
    EXPECT_TRUE(own) << own.error().to_sentence();
    auto out = std::make_unique<Insider>();
    const auto at = [](std::uint32_t port) {
      return *Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port));
    };
    out->participant = std::make_unique<RtpsParticipant>(
        ParticipantConfig{.prefix = (*own)->guid().prefix,
                          .lease_duration = kDurationInfinite,
                          .metatraffic_unicast = {at(port_of(number))},
                          .announce_to = {at(victim_.port)}},
        out->post, plugins_.events);
    EXPECT_TRUE(out->participant->enable_security(std::move(*own)));
    return out;
  }

  Node& victim_;
  const spi::PropertyList properties_ = properties_of("CN=mallory,O=Example", {}, {"Other"});
  Node plugins_{200, properties_};
  std::uint32_t count_ = 0;
};

// Otherwise 512 of them would authenticate in six seconds, and no other participant would ever
// join.
TEST(CertificatePlaces, OneCertificate_TakesHalfOfThem) {
  Pair pair({});
  pair.world.nodes = {&pair.a};
  pair.world.run(2);
  Insiders insiders(pair.a);
  std::size_t joined = 0;
  while (joined < 300 && insiders.join(pair.world.now)) ++joined;
  EXPECT_EQ(joined, Handshakes::kMaxAuthenticated / 2);
  EXPECT_EQ(pair.a->authentication_counters().authenticated, joined);
  pair.world.nodes = {&pair.a, &pair.b};
  EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 200));
}

}  // namespace
}  // namespace ddssec::rtps
