#include "governance/shadowed_expressions.hpp"

#include <algorithm>
#include <ctime>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/unit/governance/first_matched_names.hpp"

namespace ddssec::governance {
namespace {

using By = std::vector<std::uint32_t>;

std::vector<ShadowedExpression> found_shadows(std::span<const std::string_view> expressions) {
  SetEffort effort{100'000'000};
  return shadows(expressions, effort);
}

// Returns the expressions that shadow the last one; empty if a name still reaches it.
By by(std::vector<std::string_view> expressions) {
  const auto found = found_shadows(expressions);
  EXPECT_EQ(found.size(), expressions.size());
  EXPECT_EQ(found.back().is_dead, !found.back().by.empty());
  return found.back().by;
}

TEST(Shadows, AnExpressionWithinAnEarlierOne_IsDead) {
  EXPECT_EQ(by({"rt/*", "rt/chatter"}), By{0});
  EXPECT_EQ(by({"x", "rt/chatter", "rt/chatter"}), By{1});
  EXPECT_EQ(by({"*", "rt/robot[0-9]"}), By{0});
  EXPECT_EQ(by({"a*", "a*b"}), By{0});
}

TEST(Shadows, OneThatMatchesMore_IsAlive) {
  EXPECT_EQ(by({"rt/chatter", "rt/*"}), By{});
  EXPECT_EQ(by({"rt/a", "rt/b"}), By{});
  EXPECT_EQ(by({"[ab]", "[abc]"}), By{});
  EXPECT_EQ(by({"?*", "*"}), By{});
  EXPECT_EQ(by({"*"}), By{});
  EXPECT_EQ(by({"a\\*", "a\\**"}), By{}) << "the first is one name";
}

TEST(Shadows, SeveralTogether_CanDoIt) {
  EXPECT_EQ(by({"rt/a*", "x*", "rt/b*", "rt/[ab]*"}), (By{0, 2}));
  EXPECT_EQ(by({"a", "a?*", "a*"}), (By{0, 1}));
  EXPECT_EQ(by({"[a-m]", "[k-z]", "[b-y]"}), (By{0, 1}));
}

TEST(Shadows, OnlyOverlapsAllowedToCover_Count) {
  const std::string_view expressions[] = {"a*", "*", "ab"};
  SetEffort effort{1'000'000};
  const auto found = shadows(expressions, effort,
                             [](std::uint32_t a, std::uint32_t b) { return a == 1 && b == 2; });
  EXPECT_FALSE(found[1].is_dead);
  EXPECT_EQ(found[2].by, By{1});
}

// The automaton over the whole list gives the same answer.
TEST(Shadows, RandomLists_AgreeWithTheAutomaton) {
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::string> texts(1 + random() % 6);
    for (auto& text : texts)
      for (auto left = random() % 5; left > 0; --left)
        text += std::vector{"a", "b", "*", "?", "[ab]", "[!a]"}[random() % 6];
    const std::vector<std::string_view> expressions(texts.begin(), texts.end());
    const auto names = first_matched_names(expressions);
    const auto found = found_shadows(expressions);
    ASSERT_TRUE(names);
    for (std::size_t i = 0; i < found.size(); ++i)
      ASSERT_EQ(found[i].is_dead, !(*names)[i].has_value())
          << fmt::format("{}", fmt::join(texts, " ")) << i;
  }
}

TEST(Shadows, TwentyThousandExpressions_TakeNoTime) {
  std::vector<std::string> texts;
  for (int i = 0; i < 18'000; ++i) texts.push_back(fmt::format("rt/robot{}/topic{}", i % 100, i));
  for (int i = 0; i < 2000; ++i) texts.push_back(fmt::format("rq/node{}/*Request", i));
  texts.push_back("rq/node77/setRequest");
  const std::vector<std::string_view> expressions(texts.begin(), texts.end());
  const auto begin = std::clock();
  const auto found = found_shadows(expressions);
  EXPECT_LT(std::clock() - begin, 2 * CLOCKS_PER_SEC);  // processor time
  EXPECT_EQ(found.back().by, By{18'077});
  EXPECT_EQ(std::ranges::count_if(found, &ShadowedExpression::is_dead), 1);
}

// Each question may take ten million steps, and each expression asks several questions.
TEST(Shadows, AllTogether_TakeNoMoreThanTheEffort) {
  std::vector<std::string> texts;
  for (int i = 0; i < 400; ++i) texts.push_back((i % 2 ? "*a" : "*b") + std::string(i % 40, '?'));
  const std::vector<std::string_view> expressions(texts.begin(), texts.end());
  SetEffort effort{20'000'000};
  const auto begin = std::clock();
  EXPECT_EQ(shadows(expressions, effort).size(), texts.size());
  EXPECT_LT(std::clock() - begin,
            2 * CLOCKS_PER_SEC);  // processor time: 0.1 s, and 8 s without the bound
  EXPECT_EQ(effort.steps, 0u);
}

TEST(Shadows, LookingUpNames_CountsAsEffort) {
  std::vector<std::string> texts;
  for (std::size_t i = 1; i < 400; ++i)
    for (const char c : {'a', 'b'}) texts.push_back(std::string("*") + c + std::string(i, '?'));
  const std::vector<std::string_view> expressions(texts.begin(), texts.end());
  SetEffort effort{.steps = 1'000'000, .plain_steps = 100'000};
  const auto begin = std::clock();
  shadows(expressions, effort);
  EXPECT_EQ(effort.plain_steps, 0u);
  EXPECT_LT(std::clock() - begin, 2 * CLOCKS_PER_SEC) << "of this process alone";
}

TEST(Shadows, SearchWithoutEffort_FindsOnlyPlainCases) {
  SetEffort none{0};
  const std::string_view expressions[] = {"[a-m]", "[k-z]", "[b-y]", "rt/*", "rt/a"};
  const auto found = shadows(expressions, none);
  EXPECT_FALSE(found[2].is_dead);
  EXPECT_TRUE(found[4].is_dead);
}

}  // namespace
}  // namespace ddssec::governance
