// What PeersWithKeys records if memory runs out: nothing of the fact. It is part of the program
// that replaces operator new.
#include <gtest/gtest.h>

#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "tests/support/failing_memory.hpp"

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;
namespace memory = failing_memory;

constexpr spi::ParticipantCryptoHandle kLocal{1}, kPeer{70};
constexpr spi::IdentityHandle kIdentity{7};

// Calls `note` with a new object for each allocation that it makes, and lets that one fail.
// `expect_unknown` looks at the object afterwards. Returns the number of allocations.
template <class Prepare, class Note, class Expect>
long fail_each(const Prepare& prepare, const Note& note, const Expect& expect_unknown) {
  for (long number = 1;; ++number) {
    PeersWithKeys peers;
    prepare(peers);
    memory::fail_at(memory::Source::cpp, memory::Extent::once, number);
    note(peers);
    if (!memory::stop_failing()) return number - 1;
    SCOPED_TRACE(number);
    expect_unknown(peers);
  }
}

TEST(PeersWithKeysWithoutMemory, AKnownPeer_IsRecordedWholeOrNotAtAll) {
  const auto allocations =
      fail_each([](PeersWithKeys&) {},
                [](PeersWithKeys& peers) {
                  peers.note_discovered(kPeer, kIdentity, kLocal, PeersWithKeys::kSecureEndpoints);
                },
                [](PeersWithKeys& peers) {
                  EXPECT_FALSE(peers.awaits_keys());
                  peers.note_keys_sent(kPeer, kLocal);
                  EXPECT_FALSE(peers.has_sent_keys(kIdentity));
                  EXPECT_FALSE(peers.has_sent_keys(kPeer, kLocal));
                  peers.note_discovered(kPeer, kIdentity, kLocal, PeersWithKeys::kSecureEndpoints);
                  EXPECT_TRUE(peers.awaits_keys()) << "later it is recorded";
                });
  EXPECT_GE(allocations, 3);
}

TEST(PeersWithKeysWithoutMemory, AMatch_IsRecordedWholeOrNotAtAll) {
  const auto allocations = fail_each(
      [](PeersWithKeys& peers) {
        peers.add_builtin(11, kLocal);
        peers.note_discovered(kPeer, kIdentity, kLocal, PeersWithKeys::kSecureEndpoints);
      },
      [](PeersWithKeys& peers) { peers.note_matched(700, kPeer, 11); },
      [](PeersWithKeys& peers) {
        EXPECT_FALSE(peers.is_matched(kIdentity));
        peers.note_heard(700, 5s);
        EXPECT_EQ(peers.last_heard(kIdentity), 0s) << "the endpoint is known";
        peers.note_matched(700, kPeer, 11);
        EXPECT_TRUE(peers.is_matched(kIdentity)) << "later it is recorded";
      });
  EXPECT_GE(allocations, 2);
}

// The peer is known, and counts as one that has sent keys, but not to this local participant.
TEST(PeersWithKeysWithoutMemory, KeysThatWereSent_CountForNoLocalParticipant) {
  const auto allocations = fail_each(
      [](PeersWithKeys& peers) {
        peers.note_discovered(kPeer, kIdentity, kLocal, PeersWithKeys::kSecureEndpoints);
      },
      [](PeersWithKeys& peers) { peers.note_keys_sent(kPeer, kLocal); },
      [](PeersWithKeys& peers) {
        EXPECT_TRUE(peers.has_sent_keys(kIdentity));
        EXPECT_FALSE(peers.has_sent_keys(kPeer, kLocal));
        EXPECT_FALSE(peers.awaits_keys());
      });
  EXPECT_GE(allocations, 1);
}

}  // namespace
}  // namespace ddssec::cyclonedds
