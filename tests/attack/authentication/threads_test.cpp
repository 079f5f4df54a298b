// Hosts call from many threads: one plugin with two local participants, many peers that both of
// them know, and handshakes, expiry and departures at the same time.
#include <array>
#include <thread>

#include "tests/support/silent.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

// The plugin that all threads use, with its two local participants.
struct Hub {
  spi::Authentication& plugin;
  const spi::Authentication::LocalIdentity& local;
};

// One participant that authenticates with the hub, on a plugin of its own thread.
struct Spoke {
  spi::Authentication& plugin;
  spi::Authentication::LocalIdentity local;
};

// Which side sends the request depends on the GUIDs.
struct Side {
  spi::Authentication& plugin;
  spi::IdentityHandle local, remote;
  Bytes data;
};

// Returns true if both sides have the same secret.
Result<bool> handshake(const Side& first, const Side& second) {
  DDSSEC_ASSIGN_OR_RETURN(const auto request, first.plugin.begin_handshake_request(
                                                  first.local, first.remote, first.data));
  DDSSEC_ASSIGN_OR_RETURN(const auto reply,
                          second.plugin.begin_handshake_reply(*request.message, second.remote,
                                                              second.local, second.data));
  DDSSEC_ASSIGN_OR_RETURN(const auto final_message,
                          first.plugin.process_handshake(request.handle, *reply.message));
  DDSSEC_RETURN_IF_ERROR(second.plugin.process_handshake(reply.handle, *final_message.message));
  DDSSEC_ASSIGN_OR_RETURN(const auto one, first.plugin.shared_secret(request.handle));
  DDSSEC_ASSIGN_OR_RETURN(const auto other, second.plugin.shared_secret(reply.handle));
  return one->secret == other->secret;
}

// Returns the hub's handle for the spoke.
Result<spi::IdentityHandle> authenticate(const Hub& hub, const Spoke& spoke) {
  DDSSEC_ASSIGN_OR_RETURN(const auto token_of_spoke,
                          spoke.plugin.identity_token(spoke.local.handle));
  DDSSEC_ASSIGN_OR_RETURN(const auto token_of_hub, hub.plugin.identity_token(hub.local.handle));
  DDSSEC_ASSIGN_OR_RETURN(const auto of_hub,
                          hub.plugin.validate_remote_identity(hub.local.handle, {}, token_of_spoke,
                                                              spoke.local.adjusted_guid));
  DDSSEC_ASSIGN_OR_RETURN(const auto of_spoke,
                          spoke.plugin.validate_remote_identity(
                              spoke.local.handle, {}, token_of_hub, hub.local.adjusted_guid));
  const Side at_hub{hub.plugin, hub.local.handle, of_hub.handle,
                    participant_data(hub.local.adjusted_guid)};
  const Side at_spoke{spoke.plugin, spoke.local.handle, of_spoke.handle,
                      participant_data(spoke.local.adjusted_guid)};
  const bool hub_begins = of_hub.result == ValidationResult::pending_handshake_request;
  DDSSEC_ASSIGN_OR_RETURN(const bool agree,
                          hub_begins ? handshake(at_hub, at_spoke) : handshake(at_spoke, at_hub));
  EXPECT_TRUE(agree) << "the two sides have different secrets";
  return of_hub.handle;
}

TEST(HandshakeThreads, ManyPeersOfTwoLocalsOnOnePlugin_AllAuthenticate) {
  constexpr int kThreads = 4, kRounds = 25;
  const SystemClock clock;
  SystemRandom random;
  test::Silent events;
  const auto now = clock.calendar_seconds();
  const pki::Validity validity{now - 24h, now + 240h};
  const auto ca = make_ca("CN=Identity CA", {}, validity);
  const auto ours = make_authentication({clock, random, events});
  const auto hub = make_identity(ca, "CN=hub", {}, validity);
  const std::array locals{*ours->validate_local_identity(0, hub.properties, candidate(1)),
                          *ours->validate_local_identity(0, hub.properties, candidate(2))};
  std::vector<Identity> spokes;
  for (int i = 0; i < kThreads / 2; ++i)
    spokes.push_back(make_identity(ca, "CN=spoke " + std::to_string(i), {}, validity, 1));

  const auto work = [&](int index) {
    const auto theirs = make_authentication({clock, random, events});
    const auto& local = locals[static_cast<std::size_t>(index % 2)];
    const int spoke = index / 2;
    for (int round = 0; round < kRounds; ++round) {
      const auto remote = theirs->validate_local_identity(
          0, spokes[static_cast<std::size_t>(spoke)].properties,
          candidate(static_cast<std::uint8_t>(3 + spoke * kRounds + round)));
      ASSERT_OK(remote);
      const auto of_hub = authenticate({*ours, local}, {*theirs, *remote});
      ASSERT_OK(of_hub) << " in round " << round << " of thread " << index;
      (void)ours->next_expiry();
      (void)ours->poll(local.handle);
      if (round % 2 != 0) continue;
      EXPECT_TRUE(ours->return_identity_handle(*of_hub));
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  for (auto& thread : threads) thread.join();
}

}  // namespace
}  // namespace ddssec::authentication
