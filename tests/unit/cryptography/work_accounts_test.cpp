#include "plugins/cryptography/work_accounts.hpp"

#include <gtest/gtest.h>

namespace ddssec::cryptography {
namespace {

using namespace std::chrono_literals;

constexpr WorkUnits kTooMany = 33'000'000;

TEST(WorkAccounts, ParticipantThatLeaves_TakesNoDebtWithIt) {
  WorkAccounts accounts;
  accounts.of(1, 1s)->charge(kTooMany, 1s);
  EXPECT_TRUE(accounts.of(1, 1s)->is_too_large(1s));
  EXPECT_FALSE(accounts.of(2, 1s)->is_too_large(1s)) << "another certificate";
  EXPECT_FALSE(accounts.of(1, 1h)->is_too_large(1h)) << "it is paid off";
}

TEST(WorkAccounts, ParticipantsOfOneCertificate_HaveOneDebt) {
  WorkAccounts accounts;
  const auto one = accounts.of(1, 1s), other = accounts.of(1, 1s);
  one->charge(kTooMany / 2, 1s);
  EXPECT_FALSE(other->is_too_large(1s));
  other->charge(kTooMany / 2, 1s);
  EXPECT_TRUE(one->is_too_large(1s));
}

TEST(WorkAccounts, PaidOnesWithoutParticipants_AreForgotten) {
  WorkAccounts accounts;
  for (SubjectId subject = 0; subject < 1000; ++subject) accounts.of(subject, 1s);
  EXPECT_EQ(accounts.size(), 1u);
}

TEST(WorkAccounts, OnesInUseOrInDebt_AreKept) {
  WorkAccounts accounts;
  const auto used = accounts.of(1, 1s);
  accounts.of(2, 1s)->charge(1'000'000, 1s);
  accounts.of(3, 1s);
  EXPECT_EQ(accounts.size(), 3u);
  accounts.of(3, 1h);
  EXPECT_EQ(accounts.size(), 2u) << "the debt of 2 is paid off";
}

}  // namespace
}  // namespace ddssec::cryptography
