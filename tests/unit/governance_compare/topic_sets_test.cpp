#include "governance/topic_sets.hpp"

#include <map>

#include <gtest/gtest.h>

#include "governance/pattern.hpp"
#include "tests/unit/governance/first_matched_names.hpp"
#include "tests/unit/governance_compare/words.hpp"

namespace ddssec::governance {
namespace {

using Kind = SetAnswer::Kind;
using Views = std::vector<std::string_view>;

struct Row {
  Views inner, outer;
  Kind kind;
  std::string witness;
};

class Containment : public ::testing::TestWithParam<Row> {};

TEST_P(Containment, EachQuestion_IsDecidedWithTheShortestExample) {
  const auto answer = contained(GetParam().inner, GetParam().outer);
  EXPECT_EQ(answer.kind, GetParam().kind);
  EXPECT_EQ(answer.witness, GetParam().witness);
}

INSTANTIATE_TEST_SUITE_P(
    Table, Containment,
    testing::Values(
        Row{{"rt/chatter"}, {"rt/*"}, Kind::yes, ""},
        Row{{"rt/*"}, {"rt/chatter"}, Kind::no, "rt/"},
        Row{{"rt/[ab]*"}, {"rt/a*", "rt/b*"}, Kind::yes, ""},
        Row{{"rt/[ab]*"}, {"rt/a*"}, Kind::no, "rt/b"}, Row{{"a*b"}, {"a*", "*b"}, Kind::yes, ""},
        Row{{"a*"}, {"a", "a?*"}, Kind::yes, ""},
        // Only the empty name is missing.
        Row{{"*"}, {"?*"}, Kind::no, ""}, Row{{"*"}, {"?*", ""}, Kind::yes, ""},
        Row{{"??*"}, {"?*?"}, Kind::yes, ""}, Row{{"?*?"}, {"??*"}, Kind::yes, ""},
        Row{{"[!a]"}, {"[b-z]", "[!a-z]"}, Kind::yes, ""},
        Row{{"rt/*"}, {"rt/*/_action/*", "rt/[!_]*"}, Kind::no, "rt/"},
        Row{{"rt/robot?/pose"}, {"rt/robot1/pose", "rt/robot2/pose"}, Kind::no, "rt/robota/pose"},
        // The empty list is in every list, and no name is in it.
        Row{{}, {}, Kind::yes, ""}, Row{{"a"}, {}, Kind::no, "a"}, Row{{}, {"a"}, Kind::yes, ""},
        Row{{"[b-a]"}, {}, Kind::yes, ""},
        // The rules of fnmatch in pattern.hpp: escapes, classes, an unclosed bracket.
        Row{{"\\*"}, {"[*]"}, Kind::yes, ""}, Row{{"\\a"}, {"a"}, Kind::yes, ""},
        Row{{"\\"}, {}, Kind::yes, ""}, Row{{"*"}, {"\\*"}, Kind::no, "a"},
        Row{{"\\\\*"}, {"\\\\x*", "\\\\[!x]*", "\\\\"}, Kind::yes, ""},
        Row{{"[[:digit:]]"}, {"[0-9]"}, Kind::yes, ""},
        Row{{"[[:alnum:]]"}, {"[a-zA-Z]", "[0-8]"}, Kind::no, "9"},
        Row{{"[^a]"}, {"[!a]"}, Kind::yes, ""}, Row{{"a["}, {"a?"}, Kind::yes, ""},
        Row{{"a?"}, {"a[", "a[!]"}, Kind::no, "aa"}, Row{{"[]]"}, {"]"}, Kind::yes, ""},
        Row{{"\xC3\xA9"}, {"?"}, Kind::no, "\xC3\xA9"}, Row{{"\xC3\xA9"}, {"??"}, Kind::yes, ""}));

TEST(Overlap, OverlappingLists_HaveACommonName) {
  const Views deny = {"rt/cmd*"}, allow = {"rt/*"}, other = {"rq/*"};
  EXPECT_EQ(overlap(deny, allow).kind, Kind::yes);
  EXPECT_EQ(overlap(deny, allow).witness, "rt/cmd");
  EXPECT_EQ(overlap(deny, other).kind, Kind::no);
  const Views left = {"a*", "x"}, right = {"*b", "y"};
  EXPECT_EQ(overlap(left, right).witness, "ab");
  const Views every = {"*"}, none = {""};
  EXPECT_EQ(overlap(every, every).witness, "a") << "a name that reads better than none";
  EXPECT_EQ(overlap(every, none).kind, Kind::yes);
  EXPECT_EQ(overlap(every, none).witness, "");
}

TEST(FirstMatchedNames, DeadRules_AreShown) {
  const Views rules = {"rt/a*", "rt/b*", "rt/[ab]x", "rt/*", "rt/chatter", "*"};
  const auto names = first_matched_names(rules);
  ASSERT_TRUE(names);
  const std::vector<std::optional<std::string>> expected = {"rt/a", "rt/b",       std::nullopt,
                                                            "rt/",  std::nullopt, "a"};
  EXPECT_EQ(*names, expected);
}

TEST(NameAtoms, RankedLists_AreWhatTheFirstMatchTells) {
  const std::vector<RankedExpression> lists = {
      {"rt/cmd*", 0, 0}, {"rt/*", 0, 1}, {"rt/*", 1, 0}, {"rt/cmd*", 1, 1}};
  const auto atoms = name_atoms(lists);
  ASSERT_TRUE(atoms);
  ASSERT_EQ(atoms->size(), 3u);
  EXPECT_EQ((*atoms)[0].witness, "a");
  EXPECT_TRUE((*atoms)[0].matches.empty());
  EXPECT_EQ((*atoms)[1].witness, "rt/");
  EXPECT_EQ((*atoms)[1].rank_in(0), 1u);
  EXPECT_EQ((*atoms)[2].witness, "rt/cmd");
  EXPECT_EQ((*atoms)[2].rank_in(0), 0u);
  EXPECT_EQ((*atoms)[2].rank_in(1), 0u);
  EXPECT_FALSE((*atoms)[2].rank_in(2));
}

TEST(NameAtoms, SeparateLists_AreAcceptanceVectors) {
  const std::vector<RankedExpression> own = {{"a*", 0, 0}, {"*b", 1, 0}, {"", 2, 0}};
  const auto atoms = name_atoms(own);
  ASSERT_TRUE(atoms);
  std::map<std::string, std::size_t> witnesses;
  for (const auto& atom : *atoms) witnesses[atom.witness] = atom.matches.size();
  const std::map<std::string, std::size_t> expected = {
      {"", 1}, {"a", 1}, {"b", 1}, {"ab", 2}, {"c", 0}};
  EXPECT_EQ(witnesses, expected);
}

class RandomExpressions {
 public:
  std::string one() {
    static constexpr std::string_view kParts[] = {"a", "b", "a",    "b",   "*",
                                                  "*", "?", "[ab]", "[!a]"};
    std::string text;
    for (std::uint32_t parts = dice_.below(4); parts > 0; --parts) {
      text += kParts[dice_.below(std::size(kParts))];
    }
    return text;
  }
  std::vector<RankedExpression> lists() {
    texts_.clear();
    texts_.reserve(8);
    std::vector<RankedExpression> result;
    for (std::uint32_t count = 1 + dice_.below(6); count > 0; --count) {
      texts_.push_back(one());
      result.push_back({texts_.back(), dice_.below(3), dice_.below(3)});
    }
    return result;
  }

 private:
  words::Dice dice_{20261121};
  std::vector<std::string> texts_;
};

using Matches = std::vector<NameAtom::Match>;

Matches first_matches(const std::vector<RankedExpression>& lists, const std::string& name) {
  std::map<std::uint32_t, std::uint32_t> best;
  for (const auto& item : lists) {
    if (!Pattern(item.expression).matches(name)) continue;
    const auto [entry, is_new] = best.try_emplace(item.list, item.rank);
    entry->second = std::min(entry->second, item.rank);
  }
  Matches matches;
  for (const auto& [list, rank] : best) matches.push_back({list, rank});
  return matches;
}

// Octets that no expression mentions behave like the letter c. Words of up to six letters reach
// every acceptance of three lists of expressions with three steps.
TEST(NameAtoms, RandomLists_AreWhatAllShortWordsSay) {
  const auto names = words::all_words("abc", 6);
  RandomExpressions random;
  for (int round = 0; round < 1500; ++round) {
    const auto lists = random.lists();
    std::map<Matches, std::string> expected;
    for (const auto& word : names) {
      auto [entry, is_new] = expected.try_emplace(first_matches(lists, word), word);
      if (!is_new && entry->second.empty()) entry->second = word;
    }
    const auto atoms = name_atoms(lists);
    ASSERT_TRUE(atoms);
    std::map<Matches, std::string> found;
    for (const auto& atom : *atoms) found[atom.matches] = atom.witness;
    ASSERT_EQ(found.size(), atoms->size());
    EXPECT_EQ(found, expected) << "round " << round;
  }
}

std::string blow_up(std::string_view beginning, int tail) {
  return std::string(beginning) + std::string(static_cast<std::size_t>(tail), '?');
}

TEST(TopicSetLimits, ExponentialQuestion_IsGivenUp) {
  const auto small_a = blow_up("*a", 5), small_b = blow_up("*[ab]", 5);
  const Views small_inner = {small_a}, small_outer = {small_b};
  EXPECT_EQ(contained(small_inner, small_outer).kind, Kind::yes);

  const auto a = blow_up("*a", 12), b = blow_up("*[ab]", 12);
  const Views inner = {a}, outer = {b};
  EXPECT_EQ(contained(inner, outer).kind, Kind::unknown);
  const std::vector<RankedExpression> both = {{a, 0, 0}, {b, 1, 0}};
  EXPECT_FALSE(name_atoms(both));
}

TEST(TopicSetLimits, EachLimit_EndsTheSearch) {
  const std::vector<RankedExpression> few = {{"ab*", 0, 0}, {"*c", 1, 0}};
  EXPECT_TRUE(name_atoms(few));
  EXPECT_FALSE(name_atoms(few, {.states = 3}));
  EXPECT_FALSE(name_atoms(few, {.atoms = 2}));
  EXPECT_FALSE(name_atoms(few, {.steps = 10}));
  EXPECT_FALSE(name_atoms(few, {.memory = 10}));
}

}  // namespace
}  // namespace ddssec::governance
