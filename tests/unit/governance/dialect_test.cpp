#include "governance/dialect.hpp"

#include <fnmatch.h>

#include <gtest/gtest.h>

#include "governance/pattern.hpp"
#include "tests/unit/governance_compare/words.hpp"

namespace ddssec::governance {
namespace {

std::optional<UnportableExpression> unportable(std::string_view expression) {
  SetEffort effort{100'000'000};
  return governance::unportable(expression, effort);
}

TEST(Dialect, ThePortableSubset_IsPortable) {
  for (const char* expression : {"", "*", "rt/*", "a?c", "rt/robot[0-9]/pose", "[!a]", "[!a-z_]x",
                                 "[a-zA-Z0-9_]", "a-b", "weiß*", "a!b", "a^b", "{a,b}", "[abc]x-"})
    EXPECT_FALSE(unportable(expression)) << expression;
}

struct Case {
  const char* expression;
  const char* witness;  // nullptr if there is none
  bool cyclone_matches_it;
};

class DialectWitness : public ::testing::TestWithParam<Case> {};

TEST_P(DialectWitness, EachDifference_IsShownByAName) {
  const auto& [expression, witness, cyclone] = GetParam();
  const auto found = unportable(expression);
  ASSERT_TRUE(found) << expression;
  EXPECT_FALSE(found->reason.empty());
  EXPECT_EQ(found->cyclonedds.has_value(), witness != nullptr);
  if (!witness) return;
  EXPECT_EQ(found->cyclonedds->name, witness) << expression;
  EXPECT_EQ(found->cyclonedds->product_matches, cyclone) << expression;
  EXPECT_NE(Pattern(expression).matches(found->cyclonedds->name), cyclone);
}

INSTANTIATE_TEST_SUITE_P(
    All, DialectWitness,
    ::testing::Values(Case{"[^abc]", "a", true},                                  //
                      Case{"[abc]-x", "a", true},                                 //
                      Case{"a[", "a[", false},                                    //
                      Case{"a[b", "a[b", false},                                  //
                      Case{"[[:alpha:]]", "a", false}, Case{"[a-]", "a", false},  //
                      Case{"[]abc]", "a", false}, Case{"[a.b]", nullptr, false},
                      Case{"[a/b]*", nullptr, false}, Case{"a\\b", "a\\b", true},
                      Case{"cmd\\*", "cmd\\", true}, Case{"a]b", nullptr, false}));

// In the standard a backslash escapes, but Fast DDS calls fnmatch with FNM_NOESCAPE.
TEST(Dialect, FastDds_TakesABackslashVerbatim) {
  const auto found = unportable("cmd\\*");
  ASSERT_TRUE(found && found->fastdds);
  EXPECT_EQ(found->fastdds->name, "cmd\\");
  EXPECT_TRUE(found->fastdds->product_matches);
  EXPECT_FALSE(unportable("a[")->fastdds) << "read alike";
}

TEST(Dialect, FastDds_IsFnmatchWithoutEscapes) {
  words::Dice dice(5);
  const auto text = [&](std::string_view alphabet, std::size_t most) {
    std::string out(dice.below(most + 1), ' ');
    for (auto& c : out) c = alphabet[dice.below(alphabet.size())];
    return out;
  };
  int matched = 0;
  for (int i = 0; i < 50'000; ++i) {
    const auto expression = text("ab*?[]-!\\", 7), name = text("ab*[\\-", 5);
    const bool expected = fnmatch(expression.c_str(), name.c_str(), FNM_NOESCAPE) == 0;
    ASSERT_EQ(Pattern(meaning_in_fastdds(expression)).matches(name), expected)
        << expression << " on " << name;
    matched += expected;
  }
  EXPECT_GT(matched, 1'000);
}

// The answers of Cyclone DDS 0.10.2, whose ac_fnmatch was called directly.
TEST(Dialect, Cyclone_IsAsMeasured) {
  struct Measured {
    const char *expression, *name;
    bool matches;
  };
  for (const auto& [expression, name, matches] :
       {Measured{"[abc]", "]", true}, {"[]abc]", "]", false},  {"[]abc]", "a", false},
        {"[^abc]", "d", false},       {"[^abc]", "^", true},   {"[abc]-x", "b-x", false},
        {"[abc]-x", "f", true},       {"a[", "a[", false},     {"a[b", "a[b", false},
        {"[[:alpha:]]", "q", false},  {"[a-]", "-", false},    {"[a-]b]", "b", false},
        {"[!]a]", "b", false},        {"[!]a]", "b]a]", true}, {"[!]", "b]", true},
        {"[!]", "b", false},          {"[a-b-c]", "-", true},  {"[-a]", "-", true},
        {"[[a]", "[", true},          {"[a]-b]", "b]", true},  {"x[!a-b]c*", "x-cde", true},
        {"x[!a-b]c*", "xac", false},  {"[b-a]", "a", false},   {"a\\*", "a\\b", true},
        {"a\\*", "a*", false},        {"a\\", "a\\", true}})
    EXPECT_EQ(Pattern(meaning_in_cyclonedds(expression)).matches(name), matches)
        << expression << ' ' << name;
}

TEST(Dialect, LongExpressions_HaveNoWitness) {
  const auto found = unportable(std::string(300, '[') + "a");
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->cyclonedds);
}

}  // namespace
}  // namespace ddssec::governance
