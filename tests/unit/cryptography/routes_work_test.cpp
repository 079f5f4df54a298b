// The cost of a peer with very many endpoints. It is measured in allocated octets, because every
// copy of routes allocates.
#include <gtest/gtest.h>

#include "tests/support/counted_memory.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr int kMany = 8000;
constexpr std::int64_t kMaxForEntering = 32'000, kMaxForLeaving = 1000;  // octets for each endpoint

// One reader of `b` that is matched with many writers of `a`. For `b` each writer has a key of its
// own. For `a` all matches have the reader's key.
struct Crowd {
  Crowd() {
    const auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    ends.push_back(two.endpoints(attributes));
    while (ends.size() < kMany) {
      auto next = ends.front();
      next.writer =
          two.a.factory().register_local_datawriter(two.a.participant, {}, attributes).value();
      two.match_endpoints(next);
      ends.push_back(next);
    }
  }
  void unregister_each() {
    for (const auto& one : ends) {
      EXPECT_TRUE(two.a.factory().unregister_datareader(one.remote_reader));
      EXPECT_TRUE(two.b.factory().unregister_datawriter(one.remote_writer));
    }
  }
  void unregister_participants() {
    EXPECT_TRUE(two.a.factory().unregister_participant(two.a.remote));
    EXPECT_TRUE(two.b.factory().unregister_participant(two.b.remote));
  }
  TwoSides two;
  std::vector<WriterToReader> ends;
};

template <class F>
std::int64_t octets_for_each(F&& f) {
  const auto before = counted_memory::octets_ever();
  f();
  return (counted_memory::octets_ever() - before) / kMany;
}

TEST(ManyEndpoints, Entering_CostsAtMostAConstantForEach) {
  EXPECT_LE(octets_for_each([] { const Crowd crowd; }), kMaxForEntering);
}

TEST(ManyEndpoints, DroppingTheirParticipant_CostsAtMostAConstantForEach) {
  Crowd crowd;
  EXPECT_LE(octets_for_each([&] { crowd.unregister_participants(); }), kMaxForLeaving);
}

// Cyclone DDS unregisters endpoints in this way.
TEST(ManyEndpoints, UnregisteringOneByOne_CostsAtMostAConstantForEach) {
  Crowd crowd;
  EXPECT_LE(octets_for_each([&] {
              crowd.unregister_each();
              crowd.unregister_participants();
            }),
            kMaxForLeaving);
}

// The plugin keeps nothing, even if Cyclone's core keeps something.
TEST(ManyParticipants, ComingAndGoing_LeavesNothingBehind) {
  constexpr int kRounds = 1000;
  constexpr std::int64_t kMaxEach = 16;
  TwoSides two(participant_attributes(ProtectionKind::encrypt_with_origin_authentication), {},
               {.host_checks_sources = false});
  const auto come_and_go = [&] {
    for (int i = 1; i <= kRounds; ++i) {
      auto secret = shared_secret(2);
      secret.peer_prefix = GuidPrefix{{0x80, 1, 2, 3, 4, 5, 6}};
      const auto remote = two.a.factory().register_matched_remote_participant(
          two.a.participant, {1000 + i}, {7}, secret);
      ASSERT_TRUE(remote);
      ASSERT_TRUE(two.a.factory().unregister_participant(*remote));
    }
  };
  come_and_go();
  const auto before = counted_memory::octets();
  come_and_go();
  EXPECT_LE(counted_memory::octets() - before, kRounds * kMaxEach);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
