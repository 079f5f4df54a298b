// A stranger is the first to announce a participant of Cyclone DDS, with a very short lease. The
// participant signs no lease, so this one must not end its session again and again.
#include "tests/attack/rtps/announced_by.hpp"
#include "tests/unit/rtps_security/deaf_pair.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Bob signs that he is of Cyclone DDS, whose signed data has no lease.
void sign_as_cyclone(Node& node) {
  auto& core = core_of(node);
  auto octets = *core.own_data;
  const Bytes ours{0x00, 0x16, 0x00, 0x04};  // PID_VENDORID, big-endian
  const auto at = std::ranges::search(octets, ours).begin();
  ASSERT_NE(at, octets.end());
  std::ranges::copy(kVendorCyclone.octets, at + 4);
  core.own_data = std::make_shared<const Bytes>(std::move(octets));
}

struct FirstLease : ::testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(FirstLease, StrangersLease_DoesNotCountAfterTheHandshake) {
  const auto [is_forged, is_encrypted] = GetParam();
  Pair pair(is_encrypted ? everything(kEncrypt) : Rules{.metadata = kEncrypt});
  auto& world = pair.world;
  auto true_data = announced_by(world, pair.b);
  sign_as_cyclone(pair.b);
  if (is_forged) {
    true_data.lease_duration = Duration{{0, 1}};
    pair.a->receive(announcement(true_data), world.now, *Locator::parse("127.0.0.9", 0));
  }
  pair.create_endpoints();
  const auto are_matched = [&] {
    return pair.a.listener.matched == 1 && pair.b.listener.matched == 1;
  };
  // A stock participant keeps its session, and its own lease of alice does not end.
  bool keeps_session = false, loses = true;
  world.filter = [&](const Node& from, Bytes datagram) {
    const bool is_lost = loses && &from == &pair.b && contains(datagram, kParticipantsSecureWriter);
    const bool is_handshake = keeps_session && contains(datagram, kStatelessMessageWriter);
    return is_lost || is_handshake ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  const auto has_keys = [](Node& ours, Node& other) {
    const auto* peer = core_of(ours).find(other->prefix());
    return peer != nullptr && peer->state.association() != nullptr;
  };
  ASSERT_TRUE(
      world.run_until([&] { return has_keys(pair.a, pair.b) && has_keys(pair.b, pair.a); }));
  treat_as_stock(pair.a, pair.b);
  be_patient(pair.b, pair.a);
  keeps_session = true;
  world.run(20);
  loses = false;
  world.run(3000);
  EXPECT_TRUE(are_matched()) << pair.a.events.text();
  int times = 0;
  for (int i = 0; i < 600; ++i) {
    world.run(10);
    times += are_matched() ? 1 : 0;
  }
  EXPECT_EQ(times, 600) << "of one minute in tenths of a second they matched";
}

INSTANTIATE_TEST_SUITE_P(All, FirstLease, ::testing::Combine(::testing::Bool(), ::testing::Bool()));

}  // namespace
}  // namespace ddssec::rtps
