#include "governance/compare/grant_diff.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <tuple>

#include "governance/compare/domain_pieces.hpp"
#include "governance/compare/partition_contexts.hpp"
#include "governance/compare/topic_pairs.hpp"

namespace ddssec::governance {
namespace {

using RulePointers = std::vector<const Rule*>;

/// Domains in which the same rules of both grants apply.
struct Group {
  RulePointers old_rules, new_rules;
  std::vector<DomainRange> domains;
};

struct Operation {
  std::string_view name;
  std::vector<Criteria> Rule::*list;
};
constexpr std::array<Operation, 2> kOperations = {
    {{"publish", &Rule::publish}, {"subscribe", &Rule::subscribe}}};

RulePointers rules_for(const Grant& grant, DomainId domain) {
  RulePointers rules;
  for (const auto& rule : grant.rules) {
    if (rule.domains.contains(domain)) rules.push_back(&rule);
  }
  return rules;
}

std::vector<RuleElement> elements_of(const RulePointers& rules, std::vector<Criteria> Rule::*list) {
  std::vector<RuleElement> elements;
  for (const Rule* rule : rules) {
    for (const auto& criteria : rule->*list) elements.push_back({rule, &criteria});
  }
  return elements;
}

/// One expression of an element.
struct TopicItem {
  const RuleElement* element;
  const Text* topic;
};

/// The expressions of the elements that entities with certain partitions can meet, in order.
std::vector<TopicItem> items_of(const std::vector<RuleElement>& elements,
                                const std::vector<std::uint32_t>& numbers) {
  std::vector<TopicItem> items;
  for (const auto number : numbers) {
    for (const auto& topic : elements[number].criteria->topics) {
      items.push_back({&elements[number], &topic});
    }
  }
  return items;
}

RuleList rule_list(const std::vector<TopicItem>& items, bool default_allow) {
  RuleList list{.default_effect = default_allow};
  for (const auto& item : items) {
    const auto number = static_cast<std::uint32_t>(list.items.size());
    list.items.push_back({item.topic->text, number, item.element->rule->allow});
  }
  return list;
}

/// Those at the end that do what the default does have no effect.
std::span<const RuleList::Item> effective(const RuleList& list) {
  std::span<const RuleList::Item> items = list.items;
  while (!items.empty() && items.back().effect == list.default_effect) {
    items = items.first(items.size() - 1);
  }
  return items;
}

bool same(const RuleList& a, const RuleList& b) {
  return a.default_effect == b.default_effect &&
         std::ranges::equal(effective(a), effective(b), [](const auto& x, const auto& y) {
           return x.expression == y.expression && x.effect == y.effect;
         });
}

std::string_view verdict_word(bool allowed) { return allowed ? "allowed" : "denied"; }
std::string_view default_word(bool allow) { return allow ? "ALLOW" : "DENY"; }
ChangeClass class_of(bool allowed_now) {
  return allowed_now ? ChangeClass::wider : ChangeClass::narrower;
}

/// Whether a participant may join, and the rule that says so; as CompiledGrant::judge_participant.
std::pair<bool, const Rule*> may_join(const Grant& grant, const RulePointers& rules) {
  for (const Rule* rule : rules) {
    if (rule->allow) return {true, rule};
    if (rule->publish.empty() && rule->subscribe.empty() && rule->relay.empty()) {
      return {false, rule};
    }
  }
  return {grant.default_allow, nullptr};
}

/// An element as it is written, and whom it is for.
struct OpaqueElement {
  const Rule* rule;
  const Criteria* criteria;
  std::string_view operation;
};

bool operator==(const OpaqueElement& a, const OpaqueElement& b) {
  return a.rule->allow == b.rule->allow && a.rule->domains == b.rule->domains &&
         a.operation == b.operation && a.criteria->topics == b.criteria->topics &&
         a.criteria->partitions == b.criteria->partitions &&
         a.criteria->data_tags == b.criteria->data_tags;
}

std::vector<OpaqueElement> relays(const Grant& grant) {
  std::vector<OpaqueElement> found;
  for (const auto& rule : grant.rules) {
    for (const auto& criteria : rule.relay) found.push_back({&rule, &criteria, "relay"});
  }
  return found;
}

std::vector<OpaqueElement> elements(const Grant& grant) {
  std::vector<OpaqueElement> found;
  for (const auto& rule : grant.rules) {
    for (const auto& operation : kOperations) {
      for (const auto& criteria : rule.*operation.list) {
        found.push_back({&rule, &criteria, operation.name});
      }
    }
  }
  return found;
}

bool has_tags(const Grant& grant) {
  return std::ranges::any_of(elements(grant), [](const OpaqueElement& element) {
    return element.criteria->data_tags.has_value();
  });
}

class Comparison {
 public:
  Comparison(const Grant& old_grant, const Grant& new_grant, const SetLimits& limits)
      : old_(old_grant), new_(new_grant), limits_(limits) {}

  GrantDiff run() {
    for (const auto& group : groups()) compare_group(group);
    compare_defaults();
    compare_opaque("relay", relays(old_), relays(new_));
    if (has_tags(old_) || has_tags(new_)) {
      compare_opaque("data_tags", elements(old_), elements(new_));
    }
    for (auto& change : diff_.changes) change.domains = joined(std::move(change.domains));
    return std::move(diff_);
  }

 private:
  /// Class and the elements that decide.
  using Key = std::tuple<ChangeClass, const Criteria*, const Criteria*>;
  /// All that a change of a rule tells but domains and partitions.
  using Told = std::tuple<std::string_view, ChangeClass, std::string, std::vector<std::string>,
                          std::vector<std::string>, int, int>;

  std::vector<Group> groups() const;
  void compare_group(const Group& group);
  void compare_joining(const Group& group);
  void compare_operation(const Group& group, const Operation& operation);
  void compare_context(const Group& group, const Operation& operation,
                       const PartitionContext& context);
  void compare_topic(const Operation& operation, const PartitionContext& context,
                     const TopicPair& pair);
  void tell(const Group& group, PermissionChange change);
  void give_up(const Group& group, const Operation& operation);
  void compare_defaults();
  void compare_opaque(std::string_view element, const std::vector<OpaqueElement>& before,
                      const std::vector<OpaqueElement>& after);

  const Grant& old_;
  const Grant& new_;
  SetLimits limits_;
  GrantDiff diff_;
  /// Where changes are in diff_.changes, so that other domains can join them.
  std::map<std::pair<Told, std::vector<std::string>>, std::size_t> told_;
  /// Of the group at hand: partitions are only examples, so one of them is enough.
  std::set<Told> told_of_group_;
  // Of the operation and the partitions at hand.
  std::vector<PermissionChange> found_;
  std::map<Key, std::size_t> known_;  ///< where in found_, so that expressions can join
  std::set<std::pair<std::size_t, const Text*>> named_;
  Direction by_default_;
  std::vector<RuleElement> old_elements_, new_elements_;
  std::vector<TopicItem> old_items_, new_items_;
};

std::vector<Group> Comparison::groups() const {
  DomainCuts cuts;
  for (const Grant* grant : {&old_, &new_}) {
    for (const auto& rule : grant->rules) cuts.add(rule.domains);
  }
  std::vector<Group> groups;
  std::map<std::pair<RulePointers, RulePointers>, std::size_t> known;
  for (const auto& piece : cuts.pieces()) {
    auto before = rules_for(old_, piece.first), after = rules_for(new_, piece.first);
    const auto [entry, is_new] = known.try_emplace({before, after}, groups.size());
    if (is_new) groups.push_back({std::move(before), std::move(after), {}});
    groups[entry->second].domains.push_back(piece);
  }
  return groups;
}

void Comparison::compare_group(const Group& group) {
  told_of_group_.clear();
  compare_joining(group);
  for (const auto& operation : kOperations) compare_operation(group, operation);
}

void Comparison::compare_joining(const Group& group) {
  const auto [before, old_rule] = may_join(old_, group.old_rules);
  const auto [after, new_rule] = may_join(new_, group.new_rules);
  if (before == after) return;
  const auto change = class_of(after);
  diff_.direction.add(change);
  if (!old_rule && !new_rule) return by_default_.add(change);
  diff_.changes.push_back({.domains = group.domains,
                           .element = "join",
                           .change = change,
                           .old_value = std::string(verdict_word(before)),
                           .new_value = std::string(verdict_word(after)),
                           .old_line = old_rule ? old_rule->line : old_.line,
                           .new_line = new_rule ? new_rule->line : new_.line});
}

void Comparison::compare_operation(const Group& group, const Operation& operation) {
  old_elements_ = elements_of(group.old_rules, operation.list);
  new_elements_ = elements_of(group.new_rules, operation.list);
  const auto contexts = partition_contexts(old_elements_, new_elements_);
  if (!contexts) return give_up(group, operation);
  diff_.is_exact = diff_.is_exact && contexts->is_exact;
  for (const auto& context : contexts->contexts) compare_context(group, operation, context);
}

void Comparison::compare_context(const Group& group, const Operation& operation,
                                 const PartitionContext& context) {
  old_items_ = items_of(old_elements_, context.old_elements);
  new_items_ = items_of(new_elements_, context.new_elements);
  const auto before = rule_list(old_items_, old_.default_allow);
  const auto after = rule_list(new_items_, new_.default_allow);
  if (same(before, after)) return;
  const auto pairs = topic_pairs(before, after, limits_);
  diff_.is_complete = diff_.is_complete && pairs.names_all_rules;
  found_.clear();
  known_.clear();
  named_.clear();
  for (const auto& pair : pairs.pairs) compare_topic(operation, context, pair);
  for (auto& change : found_) tell(group, std::move(change));
  if (!pairs.names_all_effects) give_up(group, operation);
}

void Comparison::tell(const Group& group, PermissionChange change) {
  const Told told(change.operation, change.change, change.witness, change.expressions_old,
                  change.expressions_new, change.old_line, change.new_line);
  if (!told_of_group_.insert(told).second) return;
  const auto [entry, is_new] = told_.try_emplace({told, change.partitions}, diff_.changes.size());
  if (is_new) diff_.changes.push_back(std::move(change));
  auto& domains = diff_.changes[entry->second].domains;
  domains.insert(domains.end(), group.domains.begin(), group.domains.end());
}

void Comparison::give_up(const Group& group, const Operation& operation) {
  diff_.direction.add(ChangeClass::unknown);
  tell(group, {.element = "rule",
               .operation = operation.name,
               .change = ChangeClass::unknown,
               .old_line = old_.line,
               .new_line = new_.line});
  // What else can be found quickly is still shown.
  limits_.states = std::min<std::size_t>(limits_.states, 2'000);
}

void Comparison::compare_topic(const Operation& operation, const PartitionContext& context,
                               const TopicPair& pair) {
  const auto* o = pair.old_rule ? &old_items_[*pair.old_rule] : nullptr;
  const auto* n = pair.new_rule ? &new_items_[*pair.new_rule] : nullptr;
  const bool before = o ? o->element->rule->allow : old_.default_allow;
  const bool after = n ? n->element->rule->allow : new_.default_allow;
  if (before == after) return;
  const auto change = class_of(after);
  diff_.direction.add(change);
  // Both defaults decide: that is one line for all names.
  if (!o && !n) return by_default_.add(change);
  const auto criteria = [](const TopicItem* item) {
    return item ? item->element->criteria : nullptr;
  };
  const auto [entry, is_new] =
      known_.try_emplace({change, criteria(o), criteria(n)}, found_.size());
  if (is_new) {
    found_.push_back({.element = "rule",
                      .operation = operation.name,
                      .change = change,
                      .old_value = std::string(verdict_word(before)),
                      .new_value = std::string(verdict_word(after)),
                      .is_about_topics = true,
                      .witness = pair.witness,
                      .partitions = context.partitions,
                      .old_line = o ? o->topic->line : old_.line,
                      .new_line = n ? n->topic->line : new_.line});
  }
  const auto index = entry->second;
  auto& found = found_[index];
  if (o && named_.emplace(index, o->topic).second) found.expressions_old.push_back(o->topic->text);
  if (n && named_.emplace(index, n->topic).second) found.expressions_new.push_back(n->topic->text);
}

void Comparison::compare_defaults() {
  if (old_.default_allow == new_.default_allow) return;
  const auto change = by_default_.verdict(ChangeClass::narrower, ChangeClass::wider);
  diff_.changes.insert(diff_.changes.begin(),
                       {.element = "default",
                        .change = change,
                        .old_value = std::string(default_word(old_.default_allow)),
                        .new_value = std::string(default_word(new_.default_allow)),
                        .old_line = old_.line,
                        .new_line = new_.line});
}

void Comparison::compare_opaque(std::string_view element, const std::vector<OpaqueElement>& before,
                                const std::vector<OpaqueElement>& after) {
  if (before == after) return;
  const auto [o, n] = std::ranges::mismatch(before, after);
  const auto count = [](std::size_t size) { return std::to_string(size) + " elements"; };
  diff_.direction.add(ChangeClass::unknown);
  diff_.changes.push_back({.element = element,
                           .change = ChangeClass::unknown,
                           .old_value = count(before.size()),
                           .new_value = count(after.size()),
                           .old_line = o == before.end() ? old_.line : o->criteria->line,
                           .new_line = n == after.end() ? new_.line : n->criteria->line});
}

}  // namespace

GrantDiff compare_grants(const Grant& old_grant, const Grant& new_grant, const SetLimits& limits) {
  return Comparison(old_grant, new_grant, limits).run();
}

}  // namespace ddssec::governance
