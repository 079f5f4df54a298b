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
  auto octets = *core.own_data();
  const Bytes ours{0x00, 0x16, 0x00, 0x04};  // PID_VENDORID, big-endian
  const auto at = std::ranges::search(octets, ours).begin();
  ASSERT_NE(at, octets.end());
  std::ranges::copy(kVendorCyclone.octets, at + 4);
  core.set_own_data(std::move(octets));
}

// What differs between the runs.
struct Announced {
  bool is_forged;     // a stranger announces bob first
  bool is_encrypted;  // by the governance, everything; otherwise only submessages of topics
};

std::string name_of(const ::testing::TestParamInfo<Announced>& run) {
  return std::string(run.param.is_forged ? "ForgedLease" : "TrueLease") +
         (run.param.is_encrypted ? "OfEncryptedMessages" : "OfClearMessages");
}

class FirstLease : public ::testing::TestWithParam<Announced> {
 protected:
  FirstLease() {
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      const bool is_lost = loses_secure_announcements && &from == &pair.b &&
                           contains(datagram, kParticipantsSecureWriter);
      const bool is_handshake = keeps_session && contains(datagram, kStatelessMessageWriter);
      return is_lost || is_handshake ? std::vector<Bytes>{} : one(std::move(datagram));
    };
  }

  // A stranger announces bob, with the shortest lease.
  void announce_short_lease(ParticipantData data) {
    data.lease_duration = Duration{{0, 1}};
    pair.a->receive(announcement(data), pair.world.now, *Locator::parse("127.0.0.9", 0));
  }
  bool have_keys() {
    const auto has_keys = [](Node& ours, Node& other) {
      const auto* peer = core_of(ours).find(other->prefix());
      return peer != nullptr && peer->state.association() != nullptr;
    };
    return has_keys(pair.a, pair.b) && has_keys(pair.b, pair.a);
  }
  // A stock participant keeps its session, and its own lease of alice does not end.
  void make_bob_a_stock_participant() {
    treat_as_stock(pair.a, pair.b);
    be_patient(pair.b, pair.a);
    keeps_session = true;
  }
  bool are_matched() const { return pair.a.listener.matched == 1 && pair.b.listener.matched == 1; }
  // Returns how many times the two are matched, if it is looked ten times a second.
  int times_matched_in(int tenths) {
    int times = 0;
    for (int i = 0; i < tenths; ++i) {
      pair.world.run(10);
      times += are_matched() ? 1 : 0;
    }
    return times;
  }

  Pair pair{GetParam().is_encrypted ? everything(kEncrypt) : Rules{.metadata = kEncrypt}};
  bool keeps_session = false;
  bool loses_secure_announcements = true;
};

TEST_P(FirstLease, StrangersLease_DoesNotCountAfterTheHandshake) {
  const auto true_data = announced_by(pair.world, pair.b);
  sign_as_cyclone(pair.b);
  if (GetParam().is_forged) announce_short_lease(true_data);
  pair.create_endpoints();
  ASSERT_TRUE(pair.world.run_until([&] { return have_keys(); }));
  make_bob_a_stock_participant();
  pair.world.run(20);
  loses_secure_announcements = false;
  pair.world.run(3000);
  EXPECT_TRUE(are_matched()) << pair.a.events.text();
  EXPECT_EQ(times_matched_in(600), 600) << "in the tenths of a second of one minute";
}

INSTANTIATE_TEST_SUITE_P(All, FirstLease,
                         ::testing::Values(Announced{false, false}, Announced{false, true},
                                           Announced{true, false}, Announced{true, true}),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
