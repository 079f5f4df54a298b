// Sets of expressions: the first and all that match a name.
#include "governance/pattern_set.hpp"

#include <fnmatch.h>

#include <gtest/gtest.h>

#include "tests/unit/governance/random_text.hpp"

namespace ddssec::governance {
namespace {

std::uint32_t naive_first(const std::vector<std::string>& expressions, const std::string& name) {
  for (std::uint32_t i = 0; i < expressions.size(); ++i) {
    if (fnmatch(expressions[i].c_str(), name.c_str(), 0) == 0) return i;
  }
  return PatternSet::kNone;
}

// T6 (docs/attacks.md): the first rule in the document decides, however it is found.
TEST(PatternSet, RandomSets_FindTheSameFirstMatchAsAScan) {
  RandomText random;
  int matched = 0;
  for (int round = 0; round < 400; ++round) {
    PatternSet set;
    std::vector<std::string> expressions;
    for (std::uint32_t i = 0, count = 1 + random.number(40); i < count; ++i) {
      const auto expression =
          random.number(2) ? random.of("abcd", 5) : random.of("abcd*?[]!-\\", 10);
      if (set.add(expression) == expressions.size()) expressions.push_back(expression);
    }
    set.seal();
    ASSERT_EQ(set.size(), expressions.size());
    for (int i = 0; i < 300; ++i) {
      const auto name = random.of("abcd]", 8);
      const auto expected = naive_first(expressions, name);
      ASSERT_EQ(set.first_match(name), expected) << name;
      matched += expected != PatternSet::kNone;
    }
  }
  EXPECT_GT(matched, 10'000);
}

TEST(PatternSet, RandomSets_FindAllMatches) {
  RandomText random;
  for (int round = 0; round < 100; ++round) {
    PatternSet set;
    std::vector<std::string> expressions;
    for (int i = 0; i < 60; ++i) {
      const auto expression = random.of("ab*?", 12);
      if (set.add(expression) == expressions.size()) expressions.push_back(expression);
    }
    set.seal();
    for (int i = 0; i < 100; ++i) {
      const auto name = random.of("ab", 12);
      std::vector<PatternSet::Id> found, expected;
      set.match(name, found);
      for (std::uint32_t id = 0; id < expressions.size(); ++id) {
        if (fnmatch(expressions[id].c_str(), name.c_str(), 0) == 0) expected.push_back(id);
      }
      ASSERT_EQ(found, expected) << name;
    }
  }
}

TEST(PatternSet, SameText_GetsTheSameNumber) {
  PatternSet set;
  EXPECT_EQ(set.add("a*"), 0u);
  EXPECT_EQ(set.add("b"), 1u);
  EXPECT_EQ(set.add("a*"), 0u);
  EXPECT_EQ(set.add("b"), 1u);
  EXPECT_EQ(set.size(), 2u);
}

TEST(PatternSet, EmptySet_MatchesNothing) {
  PatternSet set;
  set.seal();
  EXPECT_EQ(set.first_match("a"), PatternSet::kNone);
  EXPECT_EQ(set.first_match(""), PatternSet::kNone);
}

// T5 (docs/attacks.md): the requested topic is a name, not an expression.
TEST(PatternSet, WildcardsInNames_AreTakenLiterally) {
  PatternSet set;
  set.add("Square");
  set.add("[*]");
  set.seal();
  EXPECT_EQ(set.first_match("S*"), PatternSet::kNone);
  EXPECT_EQ(set.first_match("Squar?"), PatternSet::kNone);
  EXPECT_EQ(set.first_match("*"), 1u);
}

TEST(PatternSet, StepLimit_EndsTheMatch) {
  PatternSet set;
  const std::string many(1'000, 'a');
  set.add("*" + many + "b*");
  set.add("*a");
  set.seal();
  std::vector<PatternSet::Id> found;
  std::size_t few = 100'000, enough = 10'000'000;
  EXPECT_FALSE(set.match(many + many, found, few));
  EXPECT_EQ(few, 0u);
  EXPECT_TRUE(set.match(many + many, found, enough));
  EXPECT_EQ(found, std::vector<PatternSet::Id>{1});
  EXPECT_GT(enough, 0u);
}

TEST(PatternSet, NamesLongerThanAnyPart_AreFound) {
  PatternSet set;
  const std::string inner(100, 'x');
  set.add("*" + inner + "y*");
  set.seal();
  EXPECT_EQ(set.first_match(inner + inner + "yz"), 0u);
  EXPECT_EQ(set.first_match(inner + "z"), PatternSet::kNone);
}

}  // namespace
}  // namespace ddssec::governance
