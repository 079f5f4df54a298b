// Expressions that are generated from the names that they must match.
#include "governance/expression_text.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

bool matches(const std::string& expression, std::string_view name) {
  return Pattern(expression).matches(name);
}

TEST(ExpressionText, LiteralName_MatchesJustThatName) {
  for (const std::string name : {"rt/a", "", "*", "?x", "[a]", "a\\b", "]", "-", "!", "\\*"}) {
    const auto expression = expression_of(name);
    EXPECT_TRUE(Pattern(expression).is_literal()) << expression;
    EXPECT_TRUE(matches(expression, name)) << expression;
    EXPECT_FALSE(matches(expression, name + "x")) << expression;
  }
  EXPECT_FALSE(matches(expression_of("*"), "a"));
}

TEST(ExpressionText, SetOfOctets_MatchesEachOfThemAndNoOther) {
  std::bitset<256> set;
  for (const char c : std::string_view("a_9-]^![\\:.=\xff\x01"))
    set.set(static_cast<std::uint8_t>(c));
  const auto expression = expression_of(set);
  for (std::size_t octet = 1; octet < 256; ++octet) {
    const char c = static_cast<char>(octet);
    EXPECT_EQ(matches(expression, std::string_view(&c, 1)), set.test(octet)) << octet;
  }
}

TEST(ExpressionText, EmptySetOfOctets_MatchesNothing) {
  EXPECT_EQ(expression_of(std::bitset<256>()), kMatchesNothing);
  EXPECT_EQ(expression_of(std::bitset<256>(1)), kMatchesNothing) << "NUL occurs in no name";
  EXPECT_TRUE(Pattern(kMatchesNothing).matches_no_name());
}

TEST(ExpressionText, StepsOfAPattern_MatchTheSame) {
  for (const std::string original : {"a*?[bc]", "\\*[!a-y]x", "[[:digit:]]?", "*[]-a]"}) {
    const Pattern pattern(original);
    std::string written;
    for (const auto& step : pattern.steps()) written += expression_of(pattern, step);
    for (const char* const name :
         {"a", "ab", "axb", "axxc", "*zx", "*ax", "7x", "77", "z]", "^", ""})
      EXPECT_EQ(matches(written, name), matches(original, name)) << original << " on " << name;
  }
}

TEST(ExpressionText, Word_IsWhatEveryProductReadsLiterally) {
  for (const char c : std::string_view("azAZ09_")) EXPECT_TRUE(is_word(c)) << c;
  for (const char c : std::string_view("-/.*?[]\\!^ \x7f\xc3@`{:[")) EXPECT_FALSE(is_word(c)) << c;
}

}  // namespace
}  // namespace ddssec::governance
