// The comparison of governance documents is checked against a model that tries every short name in
// every domain.
#include <fnmatch.h>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "governance/compare/governance_diff.hpp"
#include "tests/unit/governance_compare/words.hpp"

namespace ddssec::governance {
namespace {

using Kind = ProtectionKind;

constexpr DomainId kDomains = 4;  // 0 to 3, and 9 for all others
constexpr const char* kTags[] = {"", "a", "b", "ab", "c", "aa", "bb"};
constexpr std::size_t kMax = 5;

Kind any_kind(words::Dice& dice, std::size_t kinds) { return static_cast<Kind>(dice.below(kinds)); }

// Changes few elements, so that most of two documents is the same.
class Author {
 public:
  Author(const words::Pool& pool, std::uint32_t seed) : pool_(pool), dice_(seed) {}

  Governance document() {
    Governance governance;
    for (auto rules = 1 + dice_.below(2); rules > 0; --rules) {
      governance.domain_rules.push_back(domain_rule());
    }
    return governance;
  }

  Governance edited(Governance governance) {
    for (auto edits = dice_.below(3); edits > 0; --edits) edit(governance);
    return governance;
  }

 private:
  DomainRange range() {
    const auto first = static_cast<DomainId>(dice_.below(kDomains));
    return {first,
            first + static_cast<DomainId>(dice_.below(static_cast<std::size_t>(kDomains - first)))};
  }
  TopicRule topic_rule() {
    TopicRule rule;
    rule.topic_expression = dice_.once_in(4) ? "*" : pool_.random(dice_);
    if (dice_.once_in(2)) rule.data_protection_kind = any_kind(dice_, 3);
    if (dice_.once_in(4)) edit(rule);
    return rule;
  }
  void add_tag(DomainSet& domains) {
    static constexpr const char* kExpressions[] = {"*", "a*", "?", "[!a]*", "\\a", ""};
    if (dice_.once_in(2))
      domains.tags.push_back({kTags[dice_.below(4)]});
    else
      domains.tag_expressions.push_back({kExpressions[dice_.below(6)]});
  }
  DomainRule domain_rule() {
    DomainRule rule;
    rule.domains.ranges = {range()};
    while (dice_.once_in(3)) add_tag(rule.domains);
    for (auto topics = 1 + dice_.below(3); topics > 0; --topics) {
      rule.topic_rules.push_back(topic_rule());
    }
    for (auto edits = dice_.below(3); edits > 0; --edits) edit(rule);
    return rule;
  }
  void edit(TopicRule& rule) {
    switch (dice_.below(7)) {
      case 0:
        rule.enable_discovery_protection ^= true;
        break;
      case 1:
        rule.enable_liveliness_protection ^= true;
        break;
      case 2:
        rule.enable_read_access_control ^= true;
        break;
      case 3:
        rule.enable_write_access_control ^= true;
        break;
      case 4:
        rule.metadata_protection_kind = any_kind(dice_, 5);
        break;
      case 5:
        rule.data_protection_kind = any_kind(dice_, 3);
        break;
      default:
        rule.topic_expression = pool_.random(dice_);
    }
  }
  void edit(DomainRule& rule) {
    switch (dice_.below(9)) {
      case 5:
        rule.enable_key_revision ^= true;
        break;
      case 6:
        rule.rtps_psk_protection_kind = any_kind(dice_, 3);
        break;
      case 7:
        add_tag(rule.domains);
        break;
      case 0:
        rule.allow_unauthenticated_participants ^= true;
        break;
      case 1:
        rule.enable_join_access_control ^= true;
        break;
      case 2:
        rule.discovery_protection_kind = any_kind(dice_, 5);
        break;
      case 3:
        rule.liveliness_protection_kind = any_kind(dice_, 5);
        break;
      case 4:
        rule.rtps_protection_kind = any_kind(dice_, 5);
        break;
      default:
        rule.domains.ranges.push_back(range());
    }
  }
  void edit(Governance& governance) {
    auto& rule = governance.domain_rules[dice_.below(governance.domain_rules.size())];
    auto& topics = rule.topic_rules;
    const auto at = topics.begin() + static_cast<std::ptrdiff_t>(dice_.below(topics.size()));
    switch (dice_.below(5)) {
      case 0:
        topics.insert(at, topic_rule());
        break;
      case 1:
        std::iter_swap(at, topics.begin());
        break;
      case 2:
        edit(rule);
        break;
      case 3:
        governance.domain_rules.insert(governance.domain_rules.begin(), domain_rule());
        break;
      default:
        edit(*at);
    }
  }

  const words::Pool& pool_;
  words::Dice dice_;
};

// The model below is written from the tables of the standard, without the code under test.

using Values = std::map<std::string, int>;  // elements; kinds as level * 2 + origin

int number(Kind kind) {
  constexpr int kNumbers[] = {0, 2, 4, 3, 5};
  return kNumbers[static_cast<int>(kind)];
}

bool is_kind(const std::string& element) { return element.ends_with("_kind"); }

// Returns +1 for up, -1 for down, 0 for neither, and 2 for both.
int direction(const std::string& element, int old_value, int new_value, bool effective) {
  if (element == "allow_unauthenticated_participants") return old_value ? 1 : -1;
  if (!is_kind(element)) return !effective ? 0 : new_value > old_value ? 1 : -1;
  const int level = new_value / 2 - old_value / 2, origin = new_value % 2 - old_value % 2;
  if ((level > 0 && origin < 0) || (level < 0 && origin > 0)) return 2;
  return level + origin > 0 ? 1 : -1;
}

Values values(const DomainRule& rule) {
  return {{"allow_unauthenticated_participants", rule.allow_unauthenticated_participants},
          {"enable_join_access_control", rule.enable_join_access_control},
          {"discovery_protection_kind", number(rule.discovery_protection_kind)},
          {"liveliness_protection_kind", number(rule.liveliness_protection_kind)},
          {"rtps_protection_kind", number(rule.rtps_protection_kind)},
          {"enable_key_revision", rule.enable_key_revision},
          {"rtps_psk_protection_kind", number(rule.rtps_psk_protection_kind)}};
}

Values values(const TopicRule& rule) {
  return {{"enable_discovery_protection", rule.enable_discovery_protection},
          {"enable_liveliness_protection", rule.enable_liveliness_protection},
          {"enable_read_access_control", rule.enable_read_access_control},
          {"enable_write_access_control", rule.enable_write_access_control},
          {"metadata_protection_kind", number(rule.metadata_protection_kind)},
          {"data_protection_kind", number(rule.data_protection_kind)}};
}

// Everything that is reported about two documents, as far as it can be compared.
struct Story {
  bool up = false, down = false;
  std::set<std::string> changes;
  std::set<DomainId> flag_days;
  bool operator==(const Story&) const = default;
};

class Reference {
 public:
  Reference(const words::Pool& pool, const Governance& old_document, const Governance& new_document)
      : pool_(pool), old_(old_document), new_(new_document) {}

  Story story() {
    for (const DomainId domain : {0, 1, 2, 3, 9})
      for (const char* tag : kTags) compare_in(domain, tag);
    return story_;
  }

 private:
  static bool is_for(const DomainSet& set, DomainId domain, const std::string& tag) {
    const bool in_range = std::ranges::any_of(set.ranges, [&](const DomainRange& range) {
      return range.first <= domain && domain <= range.last;
    });
    if (!in_range) return false;
    if (set.tags.empty() && set.tag_expressions.empty()) return tag.empty();
    const auto is = [&](const Text& text) { return text.text == tag; };
    const auto fits = [&](const Text& text) {
      return fnmatch(text.text.c_str(), tag.c_str(), 0) == 0;
    };
    return std::ranges::any_of(set.tags, is) || std::ranges::any_of(set.tag_expressions, fits);
  }
  static const DomainRule* rule_for(const Governance& governance, DomainId domain,
                                    const std::string& tag) {
    for (const auto& rule : governance.domain_rules)
      if (is_for(rule.domains, domain, tag)) return &rule;
    return nullptr;
  }

  std::vector<const TopicRule*> topic_rules(const DomainRule& rule) const {
    std::vector<const TopicRule*> result(pool_.words().size(), nullptr);
    for (const auto& topic : rule.topic_rules) {
      const auto& matches = pool_.matches(topic.topic_expression);
      for (std::size_t i = 0; i < result.size(); ++i) {
        if (!result[i] && matches[i]) result[i] = &topic;
      }
    }
    return result;
  }

  void changed(const std::string& element) {
    story_.changes.insert(std::to_string(domain_) + " " + tag_ + " " + element);
  }

  void compare_in(DomainId domain, const std::string& tag) {
    domain_ = domain;
    tag_ = tag;
    const auto *o = rule_for(old_, domain, tag), *n = rule_for(new_, domain, tag);
    if (!o && !n) return;
    if (!o || !n) {
      changed("domain_rule");
      story_.flag_days.insert(domain);
      (o ? story_.up : story_.down) = true;
      return;
    }
    domain_moves_.clear();
    const auto before = values(*o), after = values(*n);
    for (const auto& [element, value] : before) {
      if (value == after.at(element)) continue;
      changed(element);
      if (is_kind(element) || element == "enable_key_revision") story_.flag_days.insert(domain);
      domain_moves_.emplace_back(element, direction(element, value, after.at(element), true));
    }
    for (const auto& [element, move] : domain_moves_) take(move);
    const auto old_topics = topic_rules(*o), new_topics = topic_rules(*n);
    std::set<std::pair<const TopicRule*, const TopicRule*>> seen;
    for (std::size_t i = 0; i < old_topics.size(); ++i) {
      if (!old_topics[i] && !new_topics[i]) continue;
      if (seen.emplace(old_topics[i], new_topics[i]).second)
        compare_topic({*o, *n, old_topics[i], new_topics[i]});
    }
  }

  // Moves in opposite directions do not cancel out.
  void take(int move) {
    story_.up = story_.up || move > 0;
    story_.down = story_.down || move < 0 || move == 2;
  }

  void compare_topic(const TopicRules& rules) {
    if (!rules.old_rule || !rules.new_rule) {
      changed("topic_rule");
      story_.flag_days.insert(domain_);
      return take(rules.old_rule ? 1 : -1);
    }
    const auto before = values(*rules.old_rule), after = values(*rules.new_rule);
    for (const auto& [element, value] : before) {
      if (value == after.at(element)) continue;
      changed(element);
      story_.flag_days.insert(domain_);
      const auto& flagged = value ? rules.old_domain : rules.new_domain;
      const bool effective = element == "enable_discovery_protection"
                                 ? is_protected(flagged.discovery_protection_kind)
                             : element == "enable_liveliness_protection"
                                 ? is_protected(flagged.liveliness_protection_kind)
                                 : true;
      take(direction(element, value, after.at(element), effective));
    }
  }

  const words::Pool& pool_;
  const Governance& old_;
  const Governance& new_;
  Story story_;
  DomainId domain_ = 0;
  std::string tag_;
  std::vector<std::pair<std::string, int>> domain_moves_;
};

bool contains(const std::vector<DomainRange>& ranges, DomainId id) {
  return std::ranges::any_of(ranges,
                             [&](const DomainRange& r) { return r.first <= id && id <= r.last; });
}

// True if no rule of the documents distinguishes these tags.
bool are_alike(const Governance& a, const Governance& b, const std::string& x,
               const std::string& y) {
  const auto same = [&](const DomainRule& rule) {
    const auto is = [&](const Text& text) { return (text.text == x) == (text.text == y); };
    const auto fits = [&](const Text& text) {
      const Pattern pattern(text.text);
      return pattern.matches(x) == pattern.matches(y);
    };
    return std::ranges::all_of(rule.domains.tags, is) &&
           std::ranges::all_of(rule.domains.tag_expressions, fits);
  };
  return x.empty() == y.empty() && std::ranges::all_of(a.domain_rules, same) &&
         std::ranges::all_of(b.domain_rules, same);
}

// The report, read from the text of each change.
class Told {
 public:
  Told(const Governance& before, const Governance& after) : before_(before), after_(after) {}

  Story story_of(const GovernanceDiff& diff) const {
    Story story;
    story.up = diff.verdict == ChangeClass::stronger || diff.verdict == ChangeClass::mixed;
    story.down = diff.verdict == ChangeClass::weaker || diff.verdict == ChangeClass::mixed;
    for (const DomainId domain : {0, 1, 2, 3, 9}) {
      if (contains(diff.flag_day_domains, domain)) story.flag_days.insert(domain);
      for (const auto& change : diff.changes) {
        if (!contains(change.scope.domains, domain)) continue;
        for (const std::string tag : kTags)
          if (has_tag(change.scope.tags, tag))
            story.changes.insert(std::to_string(domain) + " " + tag + " " +
                                 std::string(change.element.element));
      }
    }
    return story;
  }

 private:
  bool has_tag(const NameSet& tags, const std::string& tag) const {
    const auto matches = [&](const std::string& e) { return Pattern(e).matches(tag); };
    const auto is_alike = [&](const std::string& example) {
      return are_alike(before_, after_, example, tag);
    };
    const bool is_example = std::ranges::any_of(tags.examples, is_alike);
    if (tags.form == NameSet::Form::some) return is_example;
    const bool listed = std::ranges::any_of(tags.expressions, matches);
    const bool in_words =
        tags.form == NameSet::Form::every || listed == (tags.form == NameSet::Form::listed);
    EXPECT_EQ(in_words, is_example) << tag;
    return in_words;
  }

  const Governance& before_;
  const Governance& after_;
};

// True if the text about topics fits the example, which is among them.
bool fits_words(const TopicSet& topics, const std::string& name) {
  return topics.others > 0 || std::ranges::any_of(topics.words, [&](const TopicWords& words) {
           const auto matches = [&](const std::string& e) { return Pattern(e).matches(name); };
           return matches(words.expression) && (words.also.empty() || matches(words.also)) &&
                  std::ranges::none_of(words.except, matches);
         });
}

// Expects that just these rules decide for each witness.
void check_witnesses(const GovernanceDiff& diff) {
  const auto first = [](const DomainRule& rule, const std::string& name) -> const TopicRule* {
    for (const auto& topic : rule.topic_rules) {
      if (Pattern(topic.topic_expression).matches(name)) return &topic;
    }
    return nullptr;
  };
  for (const auto& change : diff.changes) {
    if (!change.is_about_topics) continue;
    EXPECT_EQ(first(*change.old_domain, change.witness), change.old_topic.get()) << change.witness;
    EXPECT_EQ(first(*change.new_domain, change.witness), change.new_topic.get()) << change.witness;
    EXPECT_TRUE(fits_words(change.topics, change.witness)) << change.witness;
  }
}

// With few states, other ways to an answer are taken. They may give up, but must not give a wrong
// answer.
bool agrees_when_short_of_states(const Governance& before, const Governance& after,
                                 const GovernanceDiff& diff) {
  GovernanceDiffOptions options;
  options.limits.states = 12;
  const auto other = compare(before, after, options);
  check_witnesses(other);
  EXPECT_EQ(other.unknown_domains.empty() || other.verdict == ChangeClass::unknown ||
                other.verdict == ChangeClass::mixed,
            true);
  return other.verdict == diff.verdict || other.verdict == ChangeClass::unknown;
}

class GovernanceReference : public ::testing::TestWithParam<std::uint32_t> {};

// Words of five letters suffice to distinguish any two lists of expressions of three parts.
TEST_P(GovernanceReference, TenThousandPairs_AgreeWithTheModel) {
  static const words::Pool pool(kMax, 3);
  Author author(pool, GetParam());
  std::map<ChangeClass, int> seen;
  for (int round = 0; round < 10'000; ++round) {
    const auto before = author.document();
    const auto after = round % 4 == 0 ? author.document() : author.edited(before);
    const auto diff = compare(before, after);
    ASSERT_EQ(Told(before, after).story_of(diff), Reference(pool, before, after).story())
        << "round " << round;
    check_witnesses(diff);
    if (round % 8 == 1) {
      ASSERT_TRUE(agrees_when_short_of_states(before, after, diff)) << round;
    }
    ++seen[diff.verdict];
  }
  for (const auto verdict :
       {ChangeClass::neutral, ChangeClass::stronger, ChangeClass::weaker, ChangeClass::mixed}) {
    EXPECT_GT(seen[verdict], 300);
  }
  EXPECT_EQ(seen[ChangeClass::unknown], 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, GovernanceReference, ::testing::Range(1u, 3u));
INSTANTIATE_TEST_SUITE_P(MoreSeeds, GovernanceReference, ::testing::Range(3u, 11u));  // --long

}  // namespace
}  // namespace ddssec::governance
