#include "plugins/cryptography/cryptography_state.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

class SubjectOfPair : public ::testing::Test {
 protected:
  std::uint64_t subject(std::int64_t identity, std::optional<GuidPrefix> peer) {
    pair_.peer_prefix = peer;
    return subject_of(identity, pair_);
  }

  LocalParticipantCrypto local_;
  ParticipantPair pair_{local_};
};

TEST_F(SubjectOfPair, ProvenPrefix_CountsWithItsFirstSixOctets) {
  constexpr GuidPrefix kOne{{0x81, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  auto sibling = kOne;
  sibling.octets[11] ^= 1;
  auto other = kOne;
  other.octets[5] ^= 1;
  EXPECT_EQ(subject(1, kOne), 0x810203040506u);
  EXPECT_EQ(subject(2, sibling), subject(1, kOne));
  EXPECT_NE(subject(1, other), subject(1, kOne));
}

// The highest bit is never set in a number made of six octets, so no prefix leads to the places of
// such a peer.
TEST_F(SubjectOfPair, PairWithoutAProvenPrefix_CountsForItsIdentity) {
  EXPECT_EQ(subject(5, std::nullopt), std::uint64_t{1} << 63 | 5);
  EXPECT_NE(subject(6, std::nullopt), subject(5, std::nullopt));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
