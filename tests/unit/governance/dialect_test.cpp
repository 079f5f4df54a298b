#include "governance/dialect.hpp"

#include <gtest/gtest.h>

#include "governance/matcher.hpp"

namespace ddssec::governance {
namespace {

TEST(Dialect, ThePortableSubsetIsPortable) {
  for (const char* expression : {"", "*", "rt/*", "a?c", "rt/robot[0-9]/pose", "[!a]", "[!a-z_]x",
                                 "[a-zA-Z0-9_]", "a-b", "weiß*", "a!b", "a^b", "{a,b}", "[abc]x-"})
    EXPECT_FALSE(unportable(expression)) << expression;
}

struct Case {
  const char* expression;
  const char* witness;  ///< nullptr: none
  bool cyclone_matches_it;
};

class DialectWitness : public ::testing::TestWithParam<Case> {};

TEST_P(DialectWitness, ShowsWhereTheyDiffer) {
  const auto& [expression, witness, cyclone] = GetParam();
  const auto found = unportable(expression);
  ASSERT_TRUE(found) << expression;
  EXPECT_FALSE(found->reason.empty());
  EXPECT_EQ(found->witness.has_value(), witness != nullptr) << found->witness.value_or("");
  if (!witness) return;
  EXPECT_EQ(*found->witness, witness) << expression;
  EXPECT_EQ(found->cyclone_matches_it, cyclone) << expression;
  EXPECT_NE(Pattern(expression).matches(*found->witness), cyclone);
}

INSTANTIATE_TEST_SUITE_P(
    All, DialectWitness,
    ::testing::Values(Case{"[^abc]", "a", true},                                  //
                      Case{"[abc]-x", "a", true},                                 //
                      Case{"a[", "a[", false},                                    //
                      Case{"a[b", "a[b", false},                                  //
                      Case{"[[:alpha:]]", "a", false}, Case{"[a-]", "a", false},  //
                      Case{"[]abc]", "a", false}, Case{"[a.b]", nullptr, false},
                      Case{"[a/b]*", nullptr, false}, Case{"a\\b", nullptr, false},
                      Case{"a]b", nullptr, false}));

// What Cyclone DDS 0.10.2 answered (its ac_fnmatch, called directly).
TEST(Dialect, OfCycloneIsAsMeasured) {
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
        {"x[!a-b]c*", "xac", false},  {"[b-a]", "a", false}})
    EXPECT_EQ(Pattern(as_cyclone_reads_it(expression)).matches(name), matches)
        << expression << ' ' << name;
}

TEST(Dialect, LongExpressionsHaveNoWitness) {
  const auto found = unportable(std::string(300, '[') + "a");
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->witness);
}

}  // namespace
}  // namespace ddssec::governance
