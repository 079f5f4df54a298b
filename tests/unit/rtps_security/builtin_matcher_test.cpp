// Fast DDS announces DCPSParticipantsSecure. Versions up to 2.9 do not have it. Since 2.10, Fast
// DDS waits for our data on this topic before it takes part in anything else.
#include "rtps/participant/builtin_matcher.hpp"

#include <gtest/gtest.h>

#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Lets the peer prove that it is a participant of Fast DDS.
class AsFastDds final : public ForwardingAuthentication {
 public:
  using ForwardingAuthentication::ForwardingAuthentication;

  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle initiator,
                                                spi::IdentityHandle replier,
                                                BytesView data) override {
    return ForwardingAuthentication::begin_handshake_request(initiator, replier, changed(data));
  }
  Result<HandshakeStep> begin_handshake_reply(const spi::Token& request,
                                              spi::IdentityHandle initiator,
                                              spi::IdentityHandle replier,
                                              BytesView data) override {
    return ForwardingAuthentication::begin_handshake_reply(request, initiator, replier,
                                                           changed(data));
  }

 private:
  static Bytes changed(BytesView data) {
    constexpr std::array<std::uint8_t, 4> kVendorParameter = {0x00, 0x16, 0x00, 0x04};
    Bytes out = to_bytes(data);
    const auto at = std::ranges::search(out, kVendorParameter);
    EXPECT_FALSE(at.empty());
    if (!at.empty()) std::ranges::copy(kVendorFastDds.octets, at.end());
    return out;
  }
};

// The reader and the writer in the form of ACKNACK, HEARTBEAT and DATA.
bool is_about_participants_secure(BytesView datagram) {
  Bytes both = to_bytes(kParticipantsSecureReader.view());
  both.insert(both.end(), kParticipantsSecureWriter.octets.begin(),
              kParticipantsSecureWriter.octets.end());
  return !std::ranges::search(datagram, both).empty();
}

struct FastDds : ::testing::Test {
  FastDds()
      : host(200),
        ours(1, properties_of("CN=ours,O=Example", rules)),
        fast(2, properties_of("CN=fast,O=Example", rules), with_plugins(host)) {
    world.nodes = {&ours, &fast};
    world.filter = [this](const Node& from, Bytes datagram) {
      const bool is_about = is_about_participants_secure(datagram);
      if (is_about && &from == &ours) ++said;
      return is_about && &from == &fast && !is_heard ? std::vector<Bytes>() : one(datagram);
    };
  }
  static Node& with_plugins(Node& host) {
    const PluginServices services{host.clock, host.random, host.events};
    host.authentication =
        std::make_unique<AsFastDds>(authentication::make_authentication(services));
    host.access_control = access_control::make_access_control(services);
    host.cryptography = cryptography::make_cryptography(services);
    return host;
  }
  bool meet() {
    return world.run_until([this] { return ours.knows(fast) && fast.knows(ours); });
  }

  const Rules rules;
  Node host, ours, fast;
  World world;
  bool is_heard = true;  // for messages on DCPSParticipantsSecure
  int said = 0;          // the number of our messages on that topic
};

TEST_F(FastDds, HeardPeer_GetsOurParticipantData) {
  is_heard = false;
  ASSERT_TRUE(meet());
  world.run(100);
  EXPECT_EQ(said, 0);
  is_heard = true;
  EXPECT_TRUE(world.run_until([this] { return said >= 2; }, 300));
}

TEST_F(FastDds, UnheardPeer_IsNotSpokenTo) {
  is_heard = false;
  ASSERT_TRUE(meet());
  world.run(1000);
  EXPECT_EQ(said, 0);
}

}  // namespace
}  // namespace ddssec::rtps
