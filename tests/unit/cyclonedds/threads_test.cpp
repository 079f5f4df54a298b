// Several threads use one instance of each plugin, as Cyclone's do. Participants meet, match, send
// and leave at the same time, and the listener of the expiry timer is set and unset. Faults show
// under the thread sanitizer.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

const std::string kPki = DDSSEC_DRIVER_PKI;
const std::string kOurs = DDSSEC_PLUGIN_DIR "/libddssec_";
const Paths kPaths = {kOurs + "authentication.so", kOurs + "access_control.so",
                      kOurs + "cryptography.so"};

constexpr int kThreads = 4;
constexpr int kRounds = 8;

// Sends one message of each kind that a link can carry. Throws Refused if one does not arrive as it
// was sent.
void send(const Link& link) {
  const Octets payload(64, 7);
  // DATA of an application's writer, without payload.
  const Octets submessage = {0x15, 0x01, 0x14, 0x00, 0, 0, 16, 0, 0, 0, 0, 0,
                             0,    0,    1,    3,    0, 0, 0,  0, 1, 0, 0, 0};
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(link.receiver.decode_payload(link.sender.encode_payload(payload)).octets(), payload);
    EXPECT_EQ(link.receiver.decode_submessage(link.sender.encode_submessage(submessage)).octets(),
              submessage);
  }
}

// Sets and unsets the listeners until `stop`, so that the timers start and end all the time.
void toggle_listeners(Domain& domain, const std::atomic<bool>& stop) {
  static const dds_security_authentication_listener identities{
      [](auto*, auto) -> DDS_Security_boolean { return 1; }, nullptr};
  static const dds_security_access_control_listener permissions{
      [](auto*, auto) -> DDS_Security_boolean { return 1; }};
  auto& auth = domain.authentication();
  auto& access = domain.access_control();
  for (bool on = true; !stop; on = !on) {
    EXPECT_EQ(auth.set_listener(&auth, on ? &identities : nullptr, nullptr), 1);
    EXPECT_EQ(access.set_listener(&access, on ? &permissions : nullptr, nullptr), 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// Each thread has a participant of its own in either domain.
TEST(HostThreads, ParticipantsComingAndGoingAtTwoDomains_StillTalk) {
  Domain left(kPaths), right(kPaths);
  std::vector<std::thread> threads;
  std::atomic<bool> stop = false;
  std::thread listener([&] { toggle_listeners(left, stop); });
  for (std::uint8_t number = 0; number < kThreads; ++number)
    threads.emplace_back([&, number] {
      for (int round = 0; round < kRounds; ++round) {
        Participant a(left, kPki, "a", "encrypt", number), b(right, kPki, "b", "origin", number);
        EXPECT_THROW(Link(a, b, "Square"), Refused) << "they do not agree on what is protected";
        Participant c(right, kPki, "b", "encrypt", static_cast<std::uint8_t>(100 + number));
        const Link link(a, c, "Square");
        send(link);
      }
    });
  for (auto& thread : threads) thread.join();
  stop = true;
  listener.join();
}

// All threads share one local participant, and each thread matches it with a peer of its own.
TEST(HostThreads, PeersComingAndGoingAtOneParticipant_StillTalk) {
  Domain left(kPaths);
  Participant hub(left, kPki, "a", "origin");
  std::vector<std::thread> threads;
  std::atomic<bool> stop = false;
  std::thread listener([&] { toggle_listeners(left, stop); });
  for (std::uint8_t number = 1; number <= kThreads; ++number)
    threads.emplace_back([&, number] {
      Domain right(kPaths);
      Participant peer(right, kPki, "b", "origin", number);
      for (int round = 0; round < kRounds; ++round) {
        const Link link(hub, peer, "Square");
        send(link);
      }
    });
  for (auto& thread : threads) thread.join();
  stop = true;
  listener.join();
}

}  // namespace
}  // namespace ddssec::driver
