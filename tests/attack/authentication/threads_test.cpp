// Hosts call from many threads: one engine with two local participants, many peers that both of
// them know, and handshakes, expiry and departures at the same time.
#include <array>
#include <atomic>
#include <thread>

#include "tests/support/silent.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(HandshakeThreads, ManyPeersOfTwoLocalsOnOneEngine_AllAuthenticate) {
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

  std::atomic<int> done = 0;
  const auto work = [&](int index) {
    const auto theirs = make_authentication({clock, random, events});
    const auto* const local = &locals[static_cast<std::size_t>(index % 2)];
    const int spoke = index / 2;
    for (int round = 0; round < kRounds; ++round) {
      const auto remote = theirs->validate_local_identity(
          0, spokes[static_cast<std::size_t>(spoke)].properties,
          candidate(static_cast<std::uint8_t>(3 + spoke * kRounds + round)));
      if (!remote) return;
      const auto of_hub = ours->validate_remote_identity(
          local->handle, {}, *theirs->identity_token(remote->handle), remote->adjusted_guid);
      const auto of_spoke = theirs->validate_remote_identity(
          remote->handle, {}, *ours->identity_token(local->handle), local->adjusted_guid);
      if (!of_hub || !of_spoke) return;
      const bool hub_begins = of_hub->result == ValidationResult::pending_handshake_request;
      auto& first = hub_begins ? *ours : *theirs;
      auto& second = hub_begins ? *theirs : *ours;
      const auto hub_data = participant_data(local->adjusted_guid);
      const auto spoke_data = participant_data(remote->adjusted_guid);
      const auto request =
          hub_begins ? first.begin_handshake_request(local->handle, of_hub->handle, hub_data)
                     : first.begin_handshake_request(remote->handle, of_spoke->handle, spoke_data);
      if (!request) return;
      const auto reply = hub_begins
                             ? second.begin_handshake_reply(*request->message, of_spoke->handle,
                                                            remote->handle, spoke_data)
                             : second.begin_handshake_reply(*request->message, of_hub->handle,
                                                            local->handle, hub_data);
      if (!reply) return;
      const auto final_message = first.process_handshake(request->handle, *reply->message);
      if (!final_message || !second.process_handshake(reply->handle, *final_message->message))
        return;
      done += (*first.shared_secret(request->handle))->secret ==
              (*second.shared_secret(reply->handle))->secret;
      (void)ours->next_expiry();
      (void)ours->poll(local->handle);
      if (round % 2 == 0) (void)ours->return_identity_handle(of_hub->handle);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(done, kThreads * kRounds);
}

}  // namespace
}  // namespace ddssec::authentication
