#include "cli/agent/repeated_problem.hpp"

#include <gtest/gtest.h>

#include "base/tool_code.hpp"

namespace ddssec::cli {
namespace {

using std::chrono::hours;

TEST(RepeatedProblem, FirstOne_IsReported) {
  RepeatedProblem problem;
  EXPECT_TRUE(problem.note(tool_code::hook_failed, hours(0)));
}

TEST(RepeatedProblem, SameOne_IsReportedAgainAfterADay) {
  RepeatedProblem problem;
  problem.note(tool_code::hook_failed, hours(1));
  EXPECT_FALSE(problem.note(tool_code::hook_failed, hours(1)));
  EXPECT_FALSE(problem.note(tool_code::hook_failed, hours(24)));
  EXPECT_TRUE(problem.note(tool_code::hook_failed, hours(25)));
  EXPECT_FALSE(problem.note(tool_code::hook_failed, hours(26)));
}

TEST(RepeatedProblem, AnotherOne_IsReported) {
  RepeatedProblem problem;
  problem.note(tool_code::hook_failed, hours(1));
  EXPECT_TRUE(problem.note(tool_code::hook_too_slow, hours(1)));
}

TEST(RepeatedProblem, SameOneAfterClear_IsReported) {
  RepeatedProblem problem;
  problem.note(tool_code::hook_failed, hours(1));
  problem.clear();
  EXPECT_TRUE(problem.note(tool_code::hook_failed, hours(1)));
}

}  // namespace
}  // namespace ddssec::cli
