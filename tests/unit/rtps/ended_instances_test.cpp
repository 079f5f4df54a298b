// What builtin readers keep of instances that have ended, tested alone.
#include "rtps/dcps/ended_instances.hpp"

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

GuidPrefix identity(std::uint8_t number) { return GuidPrefix::from(Bytes(12, number)); }
KeyHash key(std::size_t number) {
  KeyHash out{};
  for (int i = 0; i < 4; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(number >> (8 * i));
  return out;
}
// Four instances of this size fit into an identity's share.
constexpr auto kQuarter = EndedInstances::kMaxOctetsPerIdentity / 4 - EndedInstances::kPrice;

TEST(EndedInstancesTest, TheOldestOfTheSameIdentity_GivesWay) {
  EndedInstances ended;
  EXPECT_THAT(ended.add(key(0), identity(1), kQuarter), IsEmpty());
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_THAT(ended.add(key(i), identity(2), kQuarter), IsEmpty());
  EXPECT_THAT(ended.add(key(5), identity(2), kQuarter), ElementsAre(key(1)));
}

TEST(EndedInstancesTest, OneThatIsThereAgain_TakesNoPlace) {
  EndedInstances ended;
  for (std::size_t i = 0; i < 4; ++i) ended.add(key(i), identity(1), kQuarter);
  ended.remove(key(0));
  EXPECT_THAT(ended.add(key(4), identity(1), kQuarter), IsEmpty());
  EXPECT_THAT(ended.add(key(1), identity(1), kQuarter), IsEmpty()) << "it is the latest now";
  EXPECT_THAT(ended.add(key(5), identity(1), kQuarter), ElementsAre(key(2)));
}

TEST(EndedInstancesTest, FullMemory_TheIdentityWithMostGivesWay) {
  EndedInstances ended;
  constexpr auto kShares = EndedInstances::kMaxOctets / EndedInstances::kMaxOctetsPerIdentity;
  for (std::size_t of = 0; of < kShares; ++of)
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_THAT(ended.add(key(4 * of + i), identity(static_cast<std::uint8_t>(of)), kQuarter),
                  IsEmpty());
  EXPECT_EQ(ended.octets(), EndedInstances::kMaxOctets);
  EXPECT_THAT(ended.add(key(1000), identity(200), 0), ElementsAre(key(0)));
  EXPECT_LE(ended.octets(), EndedInstances::kMaxOctets);
  EXPECT_EQ(ended.take_all().size(), 4 * kShares);
  EXPECT_EQ(ended.octets(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
