// The writer that owns an instance of a kept topic with OWNERSHIP EXCLUSIVE.
#include "rtps/keeper/instance_owners.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using Claim = InstanceOwners::Claim;

Guid writer(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), {{0, 0, 1, 2}}}; }
KeyHash instance(std::uint32_t number) {
  KeyHash out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return out;
}

struct InstanceOwnersTest : ::testing::Test {
  InstanceOwnersTest() {
    owners.set_writer(writer(1), 10, {});
    owners.set_writer(writer(2), 5, {});
    owners.set_writer(writer(3), 5, {});
  }
  InstanceOwners owners{MonotonicTime{10s}};
  Claim claim(std::uint8_t by, std::uint32_t of = 0, MonotonicTime now = 0s) {
    return owners.claim(instance(of), writer(by), now);
  }
};

TEST_F(InstanceOwnersTest, Claim_OfTheStrongest_CountsUntilItIsGone) {
  EXPECT_EQ(claim(2), Claim::owned);
  EXPECT_EQ(claim(1), Claim::owned);
  EXPECT_EQ(claim(2), Claim::refused);
  EXPECT_EQ(claim(2, 7), Claim::owned) << "another instance";
  owners.remove_writer(writer(1));
  EXPECT_EQ(claim(2), Claim::owned);
}

TEST_F(InstanceOwnersTest, Claim_OfEquallyStrong_GoesToTheLowerGuid) {
  EXPECT_EQ(claim(3), Claim::owned);
  EXPECT_EQ(claim(2), Claim::owned);
  EXPECT_EQ(claim(3), Claim::refused);
}

TEST_F(InstanceOwnersTest, Claim_AfterLeaseReleaseOrLessStrength_GoesToTheWeaker) {
  EXPECT_EQ(claim(1), Claim::owned);
  owners.note_lease_ended(writer(1));
  EXPECT_EQ(claim(2), Claim::owned);
  EXPECT_EQ(claim(1), Claim::owned) << "it writes again";
  owners.release(instance(0), writer(2));
  EXPECT_EQ(claim(2), Claim::refused) << "it was not the owner that unregistered";
  owners.release(instance(0), writer(1));
  EXPECT_EQ(claim(2), Claim::owned);
  EXPECT_EQ(claim(1), Claim::owned);
  owners.set_writer(writer(1), 1, {});
  EXPECT_EQ(claim(2), Claim::owned);
}

TEST_F(InstanceOwnersTest, ExpectedOwner_MakesOthersWait_ThenCountsOrIsReplaced) {
  owners.expect(instance(0), writer(9));
  owners.expect(instance(1), writer(9));
  EXPECT_EQ(claim(1), Claim::later);
  EXPECT_EQ(claim(1, 1, 11s), Claim::owned) << "it did not come";
  owners.set_writer(writer(9), 20, {});
  EXPECT_EQ(claim(1, 0, 11s), Claim::refused) << "it came";
  EXPECT_EQ(claim(9), Claim::owned);
}

// Instances that a writer is expected to own count for its share, because they are taken off it
// when it leaves.
TEST_F(InstanceOwnersTest, ExpectedOwner_OnceItComes_HasUsedItsShare) {
  constexpr std::uint32_t kHalf = InstanceOwners::kMaxInstances / 2;
  for (std::uint32_t i = 0; i < kHalf; ++i) owners.expect(instance(i), writer(4));
  owners.set_writer(writer(4), 0, GuidPrefix::from(Bytes(12, 4)));
  EXPECT_EQ(claim(4, kHalf), Claim::no_room);
  EXPECT_EQ(claim(1, kHalf), Claim::owned);
  owners.remove_writer(writer(4));
  EXPECT_EQ(owners.size(), 1u);
}

TEST_F(InstanceOwnersTest, StrongerWriterWithoutRoom_TakesNothingFromTheOwner) {
  owners.set_writer(writer(4), 20, GuidPrefix::from(Bytes(12, 4)));
  std::uint32_t count = 0;
  while (claim(4, count) == Claim::owned) ++count;
  EXPECT_EQ(claim(1, count), Claim::owned);
  EXPECT_EQ(claim(4, count), Claim::no_room);
  EXPECT_EQ(claim(2, count), Claim::refused) << "a stronger one still owns it";
}

TEST_F(InstanceOwnersTest, OneIdentity_LeavesRoomForAnother) {
  owners.set_writer(writer(4), 0, GuidPrefix::from(Bytes(12, 4)));
  owners.set_writer(writer(5), 0, GuidPrefix::from(Bytes(12, 5)));
  std::uint32_t count = 0;
  while (claim(4, count) == Claim::owned) ++count;
  EXPECT_EQ(count, InstanceOwners::kMaxInstances / 2);
  EXPECT_EQ(claim(4, count), Claim::no_room);
  EXPECT_EQ(claim(5, count), Claim::owned);
  EXPECT_EQ(claim(5, 0), Claim::refused) << "the other has the lower GUID";
  owners.remove_writer(writer(4));
  EXPECT_EQ(owners.size(), 1u);
  EXPECT_EQ(claim(5, 0), Claim::owned);
}

}  // namespace
}  // namespace ddssec::rtps
