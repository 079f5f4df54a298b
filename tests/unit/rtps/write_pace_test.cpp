#include "rtps/reliability/write_pace.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = PiggybackHeartbeats::Kind;

constexpr MonotonicTime kStart = std::chrono::seconds(5);

TEST(WritePace, OnlyQuickWrites_Wait) {
  WritePace pace;
  auto now = kStart;
  for (int i = 0; i < WritePace::kQuickWrites; ++i) pace.note_write(now += microseconds(1), 0);
  EXPECT_FALSE(pace.may_wait(Kind::none));
  pace.note_write(now += microseconds(1), 0);
  EXPECT_TRUE(pace.may_wait(Kind::none));
  EXPECT_FALSE(pace.may_wait(Kind::final));
  EXPECT_EQ(pace.longest_wait(), WritePace::kLinger);
  pace.note_write(now += WritePace::kQuick, 0);
  EXPECT_FALSE(pace.may_wait(Kind::none));
}

TEST(WritePace, AWriterThatAnswers_DoesNotWait) {
  WritePace pace;
  auto now = kStart;
  for (std::uint32_t i = 0; i < 20; ++i) pace.note_write(now += microseconds(1), i);
  EXPECT_FALSE(pace.may_wait(Kind::none));
}

TEST(WritePace, ABudget_LetsAllButQuestionsWait) {
  WritePace pace;
  pace.set_budget(Duration::from(milliseconds(7)));
  pace.note_write(kStart, 0);
  EXPECT_TRUE(pace.may_wait(Kind::final));
  EXPECT_FALSE(pace.may_wait(Kind::without_final));
  EXPECT_EQ(pace.longest_wait(), milliseconds(7));
  pace.set_budget(kDurationInfinite);
  EXPECT_EQ(pace.longest_wait(), WritePace::kMaxBudget);
}

}  // namespace
}  // namespace ddssec::rtps
