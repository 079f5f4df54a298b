// How long the agent waits for the workers of one user.
#include "cli/agent/slow_owners.hpp"

#include <gtest/gtest.h>

namespace ddssec::cli {
namespace {

using namespace std::chrono_literals;

constexpr uid_t kOwn = 0, kOwner = 1000, kOther = 1001;
constexpr auto kFull = SlowOwners::kTime, kShort = SlowOwners::kTimeIfSlow;

TEST(SlowOwners, OwnerOfASlowWorker_HasLessTimeForAnHour) {
  SlowOwners owners(kOwn);
  EXPECT_EQ(owners.time_for(kOwner, 0s), kFull);
  owners.note(kOwner, 10s);
  EXPECT_EQ(owners.time_for(kOwner, 11s), kShort);
  EXPECT_EQ(owners.time_for(kOther, 11s), kFull);
  EXPECT_EQ(owners.time_for(kOwner, 1h + 10s), kFull);
}

TEST(SlowOwners, MissOfTheShortTime_DoesNotProlongTheHour) {
  SlowOwners owners(kOwn);
  for (auto now = 0min; now < 60min; now += 10min) owners.note(kOwner, now);
  EXPECT_EQ(owners.time_for(kOwner, 1h), kFull)
      << "a token that needs 4 s would never be used again";
  owners.note(kOwner, 1h);
  EXPECT_EQ(owners.time_for(kOwner, 1h + 1s), kShort);
}

TEST(SlowOwners, OwnUser_IsNeverSlow) {
  SlowOwners owners(kOwn);
  owners.note(kOwn, 0s);
  EXPECT_EQ(owners.time_for(kOwn, 1s), kFull);
}

TEST(SlowOwners, Clear_GivesEachOwnerTheFullTime) {
  SlowOwners owners(kOwn);
  owners.note(kOwner, 0s);
  owners.clear();
  EXPECT_EQ(owners.time_for(kOwner, 1s), kFull);
}

}  // namespace
}  // namespace ddssec::cli
