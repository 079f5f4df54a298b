// A single expression: what it matches, and what that costs.
#include "governance/pattern.hpp"

#include <ctime>
#include <fnmatch.h>

#include <gtest/gtest.h>

#include "tests/support/slowdown.hpp"
#include "tests/unit/governance/random_text.hpp"

namespace ddssec::governance {
namespace {

bool matches(std::string_view expression, std::string_view name) {
  return Pattern(expression).matches(name);
}

struct Row {
  const char* expression;
  const char* name;
  bool matches;
};

class PatternRow : public testing::TestWithParam<Row> {};

TEST_P(PatternRow, EachRow_IsAsTheStandardSays) {
  EXPECT_EQ(matches(GetParam().expression, GetParam().name), GetParam().matches);
}

TEST_P(PatternRow, EachRow_IsAsTheLibrarySays) {
  EXPECT_EQ(fnmatch(GetParam().expression, GetParam().name, 0) == 0, GetParam().matches);
}

INSTANTIATE_TEST_SUITE_P(
    Table, PatternRow,
    testing::Values(
        Row{"", "", true}, Row{"", "a", false}, Row{"*", "", true}, Row{"?", "", false},
        Row{"Square", "Square", true}, Row{"Square", "square", false}, Row{"Squ*", "Square", true},
        Row{"S?uare", "Square", true}, Row{"S?uare", "Suare", false}, Row{"rt/*", "rt/a/b", true},
        Row{"*", ".hidden", true}, Row{"rt/?", "rt//", true}, Row{"a\\*", "a*", true},
        // A backslash escapes (POSIX fnmatch without flags).
        Row{"a\\*", "a\\b", false}, Row{"a\\b", "ab", true}, Row{"a\\b", "a\\b", false},
        Row{"a\\\\b", "a\\b", true}, Row{"*\\?", "x?", true}, Row{"*\\?", "xy", false},
        Row{"a\\", "a", false}, Row{"a\\", "a\\", false}, Row{"*\\", "x\\", false},
        Row{"\\[a]", "[a]", true}, Row{"\\[a]", "a", false}, Row{"[\\]a]", "]", true},
        Row{"[\\]a]", "\\", false}, Row{"[a\\-c]", "-", true}, Row{"[a\\-c]", "b", false},
        Row{"[a-\\c]", "b", true}, Row{"[\\!a]", "!", true}, Row{"[a\\]", "[a]", true},
        Row{"*a*b*c", "xaybzc", true}, Row{"*a*b*c", "xaybz", false}, Row{"**", "x", true},
        Row{"a**b", "ab", true},
        // Measured: Cyclone's matcher answers some of these differently.
        Row{"[abc]", "]", false}, Row{"[]abc]", "]", true}, Row{"[^abc]", "d", true},
        Row{"[^abc]", "a", false}, Row{"[!abc]", "d", true}, Row{"[abc]-x", "b-x", true},
        Row{"[abc]-x", "f", false}, Row{"a[", "a[", true}, Row{"a[b", "a[b", true},
        Row{"[[:alpha:]]", "q", true}, Row{"[[:alpha:]]", "1", false}, Row{"[a-]", "-", true},
        Row{"[!]a]", "b", true}, Row{"[!]a]", "]", false}, Row{"[a-c]", "b", true},
        Row{"[c-a]", "b", false}, Row{"[a-c-e]", "d", false}, Row{"[a-c-e]", "-", true},
        Row{"[[:digit:]x]", "x", true}, Row{"[[:digit:]x]", "7", true},
        Row{"[![:digit:]]", "7", false}, Row{"[[.a.]]", "a", true}, Row{"[[=a=]]", "a", true},
        Row{"[]-a]", "^", true}, Row{"[*]", "*", true}, Row{"[*]", "a", false},
        Row{"[?]x", "?x", true}, Row{"?", "\xC3", true}, Row{"?", "\xC3\xA9", false}));

TEST(Pattern, RandomPatterns_AgreeWithFnmatch) {
  RandomText random;
  int matched = 0;
  for (int i = 0; i < 400'000; ++i) {
    const std::string expression = random.of("ab-*?[]!^\\/c", 9);
    const std::string name = random.of("abc-]^!/*?[\\", 7);
    const bool expected = fnmatch(expression.c_str(), name.c_str(), 0) == 0;
    ASSERT_EQ(matches(expression, name), expected) << expression << " on " << name;
    matched += expected;
  }
  EXPECT_GT(matched, 10'000);
}

TEST(Pattern, EachCharacterClass_HasTheCharactersOfFnmatch) {
  for (const std::string name : {"alpha", "digit", "alnum", "upper", "lower", "space", "blank",
                                 "punct", "print", "graph", "cntrl", "xdigit"}) {
    const auto expression = "[[:" + name + ":]]";
    for (char c = 1; c < 127; ++c) {
      const std::string character(1, c);
      EXPECT_EQ(matches(expression, character),
                fnmatch(expression.c_str(), character.c_str(), 0) == 0)
          << expression << " on " << int{c};
    }
  }
}

TEST(Pattern, PatternsThatMatchNoName_AreKnown) {
  for (const auto* expression : {"[z-a]", "a[z-a]*", "a\\", "[!\x01-\xff]"})
    EXPECT_TRUE(Pattern(expression).matches_no_name()) << expression;
  for (const auto* expression :
       {"", "*", "a", "[a-z]", "[\\a]", "[", "[!a]", "[/]", "[^\x01-\xfe]"})
    EXPECT_FALSE(Pattern(expression).matches_no_name()) << expression;
  for (const auto* expression : {"[/a]", "[a/]*", "[!\x01-.0-\xff]"})
    EXPECT_TRUE(Pattern(expression, Pattern::Syntax::subject).matches_no_name()) << expression;
  EXPECT_FALSE(Pattern("a\\", Pattern::Syntax::subject).matches_no_name());
}

TEST(Pattern, RandomPatternsWithSlashes_AgreeWithFnmatch) {
  RandomText random;
  int matched = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::string expression = random.of("ab*?/\\", 8);
    const std::string name = random.of("ab/\\", 6);
    const bool expected =
        fnmatch(expression.c_str(), name.c_str(), FNM_NOESCAPE | FNM_PATHNAME) == 0;
    ASSERT_EQ(Pattern(expression, Pattern::Syntax::subject).matches(name), expected)
        << expression << " on " << name;
    matched += expected;
  }
  EXPECT_GT(matched, 3'000);
}

std::string repeated(std::string_view unit, std::size_t octets) {
  std::string text;
  while (text.size() < octets) text += unit;
  return text;
}

// Returns processor time, which a busy machine changes little.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A peer's partition is such an expression. A search to the end from each '[' took a processor 12 s
// for 4,000 octets of "[:".
TEST(Pattern, LongExpression_CompilesInLinearTime) {
  constexpr double kMaxSecondsPerOctet = 5e-6;  // about 100 times the measured time
  for (const std::string_view unit :
       {"[",      "[:",  "[=", "[.",  "[[:", "[[=", "[[.",  "[:a",    "[[:a:]",
        "[[:x:]", "[a-", "[!", "[^[", "[]",  "[\\", "[\\]", "[[.a.]", "[[.ab.]",
        "[[==]",  "\\",  "*",  "*?",  "?*[", "[a]", "a"})
    for (const std::string_view end : {"", "]", ":]", ".]", "=]", "[.ab.]]", "\\"})
      for (const std::size_t octets : {1'000, 8'000, 64'000}) {
        const auto text = repeated(unit, octets) + std::string(end);
        const auto begin = cpu_seconds();
        const Pattern pattern(text);
        ASSERT_LT(cpu_seconds() - begin,
                  test::kSlowdown * kMaxSecondsPerOctet * static_cast<double>(octets))
            << octets << " octets of " << unit << ", then " << end;
      }
}

TEST(Pattern, LongName_MatchesInExpressionTimesName) {
  const std::string name(1'000, 'a');
  for (const std::string_view unit : {"*a", "*?", "*[a]", "**a", "*[ab]*", "?*", "*[!b]a"}) {
    const Pattern pattern(repeated(unit, 4'000) + "b");
    const auto begin = cpu_seconds();
    EXPECT_FALSE(pattern.matches(name));
    EXPECT_LT(cpu_seconds() - begin, 1) << unit;
  }
}

TEST(Pattern, ASlashBetweenBracketsOfASubject_MatchesNothing) {
  for (const char* name : {"a", "/", "b", "[a/b]"})
    EXPECT_FALSE(Pattern("[a/b]", Pattern::Syntax::subject).matches(name)) << name;
}

TEST(Pattern, ALiteral_HasTheNameThatItMatches) {
  EXPECT_TRUE(Pattern("rt\\/a\\*").is_literal());
  EXPECT_EQ(Pattern("rt\\/a\\*").text(), "rt/a*");
  EXPECT_FALSE(Pattern("a\\").is_literal());
}

// After a star, the letters are tried at each place of the name.
TEST(Pattern, StepLimit_EndsTheMatch) {
  const std::string many(1'000, 'a');
  const Pattern pattern("*" + many + "b");
  std::size_t few = 100'000, enough = 3'000'000;
  EXPECT_EQ(pattern.matches(many + many, few), std::nullopt);
  EXPECT_EQ(few, 0u);
  EXPECT_EQ(pattern.matches(many + many, enough), false);
  EXPECT_LT(enough, 2'000'000u);
  EXPECT_GT(enough, 0u);
}

}  // namespace
}  // namespace ddssec::governance
