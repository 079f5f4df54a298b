#include "governance/compare/governance_diff.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "base/ordered.hpp"
#include "governance/compare/domain_pieces.hpp"
#include "governance/compare/topic_pairs.hpp"
#include "governance/matcher.hpp"

namespace ddssec::governance {
namespace {

/// Domains in which the same two rules apply.
struct Group {
  const DomainRule* old_rule;
  const DomainRule* new_rule;
  std::vector<DomainRange> domains;
  std::vector<std::string> tags;
};

/// One topic rule's values as a number; 0 is kept for "no rule".
std::uint32_t effect_of(const TopicRule& rule) {
  std::uint32_t value = 1;
  for (const bool flag : {rule.enable_discovery_protection, rule.enable_liveliness_protection,
                          rule.enable_read_access_control, rule.enable_write_access_control}) {
    value = value * 2 + flag;
  }
  value = value * 8 + static_cast<std::uint32_t>(rule.metadata_protection_kind);
  return value * 8 + static_cast<std::uint32_t>(rule.data_protection_kind);
}

RuleList rule_list(const DomainRule& rule) {
  RuleList list;
  for (const auto& topic : rule.topic_rules) {
    const auto number = static_cast<std::uint32_t>(list.items.size());
    list.items.push_back({topic.topic_expression, number, effect_of(topic)});
  }
  return list;
}

bool same_rules(const DomainRule& a, const DomainRule& b) {
  return std::ranges::equal(a.topic_rules, b.topic_rules, [](const auto& x, const auto& y) {
    return x.topic_expression == y.topic_expression && effect_of(x) == effect_of(y);
  });
}

/// The names that were asked for, the first of each two rules.
TopicPairs pairs_of(const std::vector<std::string>& topics, const DomainRule& old_rule,
                    const DomainRule& new_rule) {
  const RuleFinder old_rules(rule_list(old_rule)), new_rules(rule_list(new_rule));
  std::set<std::pair<std::optional<std::uint32_t>, std::optional<std::uint32_t>>> known;
  TopicPairs result;
  for (const auto& topic : topics) {
    const auto o = old_rules.first(topic), n = new_rules.first(topic);
    if (known.emplace(o, n).second) result.pairs.push_back({o, n, topic});
  }
  return result;
}

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (std::ranges::find(list, text) == list.end()) list.push_back(text);
}

bool concerns_payload(const Properties& properties) {
  constexpr Property kPayload[] = {
      Property::outsider_payload_secrecy, Property::outsider_payload_integrity,
      Property::insider_payload_secrecy, Property::insider_payload_integrity};
  return std::ranges::any_of(
      kPayload, [&](Property p) { return properties.test(static_cast<std::size_t>(p)); });
}

/// Which way one topic goes, by everything that changes for it.
Direction direction_of(std::span<const ElementChange> domain, std::span<const ElementChange> topic,
                       const Properties& lost, const Properties& gained) {
  Direction all, certain;
  for (const auto& changes : {domain, topic}) {
    for (const auto& change : changes) {
      all.add(change.change);
      if (!change.is_layered || change.change == ChangeClass::mixed) certain.add(change.change);
    }
  }
  if (!all.up() || !all.down()) return all;
  if (lost.any()) certain.add(ChangeClass::weaker);
  const bool made_up_for = concerns_payload(lost) && !concerns_payload(gained);
  if (gained.any() && !made_up_for) certain.add(ChangeClass::stronger);
  return certain;
}

/// Element, both values, class, properties lost and gained.
using TopicChangeKey =
    std::tuple<std::string_view, std::string, std::string, ChangeClass, std::string>;

/// Where a change is in the result, and the rules that are named there.
struct KnownChange {
  std::size_t index;
  std::set<const TopicRule*> rules = {};
};

class Comparison {
 public:
  Comparison(const Governance& old_document, const Governance& new_document,
             const GovernanceDiffOptions& options)
      : old_(old_document), new_(new_document), options_(options), limits_(options.limits) {}

  GovernanceDiff run() {
    if (!group_domains()) {
      direction_.add(ChangeClass::unknown);
      diff_.unknown_domains.push_back({0, kHighestDomainId});
    }
    for (const auto& group : groups_) compare_group(group);
    diff_.flag_day_domains = joined(std::move(diff_.flag_day_domains));
    diff_.unknown_domains = joined(std::move(diff_.unknown_domains));
    diff_.verdict = direction_.verdict(ChangeClass::stronger, ChangeClass::weaker);
    order_by_greatest(diff_.changes, [](const GovernanceChange& change) {
      return std::pair(change.element.change, !change.is_about_topics);
    });
    return std::move(diff_);
  }

 private:
  bool group_domains();
  std::optional<std::vector<std::string>> tags() const;
  void compare_group(const Group& group);
  TopicPairs pairs_in(const Group& group);
  void compare_topic(const Group& group, const TopicPair& pair);
  void add_domain_change(const Group& group, const ElementChange& element);
  void add_topic_change(const Group& group, GovernanceChange change);
  void note_rewritten(const Group& group);

  const Governance& old_;
  const Governance& new_;
  const GovernanceDiffOptions& options_;
  SetLimits limits_;
  std::vector<Group> groups_;
  GovernanceDiff diff_;
  Direction direction_;
  // Of the group at hand.
  std::vector<ElementChange> domain_changes_;
  Properties lost_, gained_;
  /// Changes of topics by what they are, so that more rules can join them.
  std::map<TopicChangeKey, KnownChange> topic_changes_;
  bool any_topic_ = false;
};

/// A tag is literal, a tag expression is not.
std::string as_expression(std::string_view literal) {
  std::string text;
  for (const char c : literal) {
    const bool special = c == '*' || c == '?' || c == '[';
    text += special ? std::string{'[', c, ']'} : std::string(1, c);
  }
  return text;
}

/// More than these tags and tag expressions are not compared.
constexpr std::size_t kMostTags = 64;

std::optional<std::vector<std::string>> Comparison::tags() const {
  std::set<std::string> expressions = {""};
  for (const Governance* document : {&old_, &new_}) {
    for (const auto& rule : document->domain_rules) {
      for (const auto& tag : rule.domains.tags) expressions.insert(as_expression(tag.text));
      for (const auto& tag : rule.domains.tag_expressions) expressions.insert(tag.text);
      if (expressions.size() > kMostTags) return std::nullopt;
    }
  }
  // Without any, only participants without a tag are spoken of.
  if (expressions.size() == 1) return std::vector<std::string>{""};
  std::vector<RankedExpression> own;
  for (const auto& expression : expressions) {
    own.push_back({expression, static_cast<std::uint32_t>(own.size()), 0});
  }
  const auto atoms = name_atoms(own, {.states = 20'000, .atoms = 4 * kMostTags});
  if (!atoms) return std::nullopt;
  std::vector<std::string> witnesses;
  for (const auto& atom : *atoms) witnesses.push_back(atom.witness);
  return witnesses;
}

bool Comparison::group_domains() {
  DomainCuts cuts;
  for (const Governance* document : {&old_, &new_}) {
    for (const auto& rule : document->domain_rules) cuts.add(rule.domains);
  }
  const auto tag_names = tags();
  if (!tag_names) return false;
  std::map<std::pair<const DomainRule*, const DomainRule*>, std::size_t> known;
  for (const auto& tag : *tag_names) {
    for (const auto& piece : cuts.pieces()) {
      const auto* o = old_.find(piece.first, tag);
      const auto* n = new_.find(piece.first, tag);
      if (!o && !n) continue;
      const auto [entry, is_new] = known.try_emplace({o, n}, groups_.size());
      if (is_new) groups_.push_back({o, n, {}, {}});
      Group& group = groups_[entry->second];
      group.domains.push_back(piece);
      if (tag_names->size() > 1) add_once(group.tags, tag);
    }
  }
  for (auto& group : groups_) group.domains = joined(std::move(group.domains));
  return true;
}

void Comparison::compare_group(const Group& group) {
  domain_changes_ = compare_domain_rules(group.old_rule, group.new_rule);
  lost_.reset();
  gained_.reset();
  topic_changes_.clear();
  any_topic_ = false;
  const bool both = group.old_rule && group.new_rule;
  if (both && (!domain_changes_.empty() || !same_rules(*group.old_rule, *group.new_rule))) {
    const std::size_t before = diff_.changes.size();
    const auto pairs = pairs_in(group);
    for (const auto& pair : pairs.pairs) compare_topic(group, pair);
    diff_.complete = diff_.complete && pairs.names_all_rules;
    if (!pairs.names_all_effects) {
      direction_.add(ChangeClass::unknown);
      diff_.unknown_domains.insert(diff_.unknown_domains.end(), group.domains.begin(),
                                   group.domains.end());
    } else if (diff_.changes.size() == before) {
      note_rewritten(group);
    }
  }
  for (const auto& change : domain_changes_) {
    if (!any_topic_) direction_.add(change.change);
    add_domain_change(group, change);
  }
}

TopicPairs Comparison::pairs_in(const Group& group) {
  if (!options_.topics.empty()) return pairs_of(options_.topics, *group.old_rule, *group.new_rule);
  auto pairs = topic_pairs(rule_list(*group.old_rule), rule_list(*group.new_rule), limits_);
  // Something is unknown already: what else can be found quickly is still shown.
  if (!pairs.names_all_effects) limits_.states = std::min<std::size_t>(limits_.states, 2'000);
  return pairs;
}

void Comparison::compare_topic(const Group& group, const TopicPair& pair) {
  const auto* o = pair.old_rule ? &group.old_rule->topic_rules[*pair.old_rule] : nullptr;
  const auto* n = pair.new_rule ? &group.new_rule->topic_rules[*pair.new_rule] : nullptr;
  if (!o && !n) return;
  const auto changes = compare_topic_rules({*group.old_rule, *group.new_rule, o, n});
  if (changes.empty() && domain_changes_.empty()) return;
  GovernanceChange change{.is_about_topics = true,
                          .witness = pair.witness,
                          .old_domain = group.old_rule,
                          .new_domain = group.new_rule,
                          .old_topic = o,
                          .new_topic = n};
  if (o && n) {
    const auto before = properties(*group.old_rule, *o), after = properties(*group.new_rule, *n);
    change.lost = before & ~after;
    change.gained = after & ~before;
  }
  any_topic_ = true;
  // What topics lose by rules of their own is told there.
  if (changes.empty()) {
    lost_ |= change.lost;
    gained_ |= change.gained;
  }
  direction_.add(direction_of(domain_changes_, changes, change.lost, change.gained));
  for (const auto& element : changes) {
    change.element = element;
    add_topic_change(group, change);
  }
}

void Comparison::add_topic_change(const Group& group, GovernanceChange change) {
  const auto& e = change.element;
  const auto key = std::tuple(e.element, e.old_value, e.new_value, e.change,
                              change.lost.to_string() + change.gained.to_string());
  const auto [entry, is_new] = topic_changes_.try_emplace(key, KnownChange{diff_.changes.size()});
  if (is_new) {
    change.domains = group.domains;
    change.tags = group.tags;
    diff_.changes.push_back(change);
    if (e.interop != Interop::none) {
      diff_.flag_day_domains.insert(diff_.flag_day_domains.end(), group.domains.begin(),
                                    group.domains.end());
    }
  }
  auto& [index, rules] = entry->second;
  const auto name = [&](const TopicRule* rule, std::vector<std::string>& expressions) {
    if (rule && rules.insert(rule).second) expressions.push_back(rule->topic_expression);
  };
  name(change.old_topic, diff_.changes[index].expressions_old);
  name(change.new_topic, diff_.changes[index].expressions_new);
}

void Comparison::add_domain_change(const Group& group, const ElementChange& element) {
  diff_.changes.push_back({.domains = group.domains,
                           .tags = group.tags,
                           .element = element,
                           .lost = lost_,
                           .gained = gained_,
                           .old_domain = group.old_rule,
                           .new_domain = group.new_rule});
  if (element.interop == Interop::none) return;
  diff_.flag_day_domains.insert(diff_.flag_day_domains.end(), group.domains.begin(),
                                group.domains.end());
}

void Comparison::note_rewritten(const Group& group) {
  const auto missing = [](const DomainRule& from, const DomainRule& in) {
    std::vector<std::string> texts;
    for (const auto& rule : from.topic_rules) {
      const bool there = std::ranges::find(in.topic_rules, rule.topic_expression,
                                           &TopicRule::topic_expression) != in.topic_rules.end();
      if (!there) add_once(texts, rule.topic_expression);
    }
    return texts;
  };
  if (same_rules(*group.old_rule, *group.new_rule)) return;
  diff_.rewritten.push_back({group.domains, missing(*group.old_rule, *group.new_rule),
                             missing(*group.new_rule, *group.old_rule)});
}

int line_of(const DomainRule* domain, const TopicRule* topic) {
  return topic ? topic->line : domain ? domain->line : 0;
}

}  // namespace

int GovernanceChange::old_line() const { return line_of(old_domain, old_topic); }
int GovernanceChange::new_line() const { return line_of(new_domain, new_topic); }

GovernanceDiff compare(const Governance& old_document, const Governance& new_document,
                       const GovernanceDiffOptions& options) {
  return Comparison(old_document, new_document, options).run();
}

}  // namespace ddssec::governance
