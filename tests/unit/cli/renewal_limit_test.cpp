#include "cli/agent/renewal_limit.hpp"

#include <gtest/gtest.h>

namespace ddssec::cli {
namespace {

using std::chrono::days;
using std::chrono::hours;
using std::chrono::seconds;

TEST(RenewalLimit, TwoAnswers_MayFollowEachOther) {
  RenewalLimit limit;
  EXPECT_TRUE(limit.allows(hours(1)));
  limit.note(days(365), hours(1));
  EXPECT_TRUE(limit.allows(hours(1)));
  limit.note(days(365), hours(1));
  EXPECT_FALSE(limit.allows(hours(1)));
}

TEST(RenewalLimit, AfterTwoAnswers_OneInEachHour) {
  RenewalLimit limit;
  int answers = 0;
  for (auto now = seconds(hours(1)); now < hours(25); now += seconds(1)) {
    if (!limit.allows(now)) continue;
    limit.note(days(365), now);
    ++answers;
  }
  EXPECT_EQ(answers, 25);
}

TEST(RenewalLimit, ShortLivedCertificates_AreRenewedAtTwoThirds) {
  for (const auto lifetime : {seconds(3), seconds(9), seconds(60), seconds(3600)}) {
    RenewalLimit limit;
    for (int renewals = 1; renewals < 100; ++renewals) {
      const auto now = renewals * lifetime * 2 / 3;
      EXPECT_TRUE(limit.allows(now)) << lifetime << ", " << renewals;
      limit.note(lifetime, now);
    }
  }
}

TEST(RenewalLimit, AfterClear_AllowsAtOnce) {
  RenewalLimit limit;
  for (int answers = 0; answers < 5; ++answers) limit.note(days(1), hours(1));
  EXPECT_FALSE(limit.allows(hours(1)));
  limit.clear();
  EXPECT_TRUE(limit.allows(hours(1)));
}

}  // namespace
}  // namespace ddssec::cli
