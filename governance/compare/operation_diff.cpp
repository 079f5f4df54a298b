#include "governance/compare/operation_diff.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <tuple>

#include "governance/compare/entity_contexts.hpp"
#include "governance/compare/topic_pairs.hpp"

namespace ddssec::governance {
namespace {

std::vector<RuleElement> elements_of(const RulePointers& rules,
                                     std::vector<Criteria> GrantRule::*list) {
  std::vector<RuleElement> elements;
  for (const GrantRule* rule : rules) {
    for (const auto& criteria : rule->*list) elements.push_back({rule, &criteria});
  }
  return elements;
}

// One expression of an element.
struct TopicItem {
  const RuleElement* element;
  const Text* topic;
};

// The expressions of the elements that entities can match, in order, as a list of rules.
struct ItemList {
  std::vector<TopicItem> items = {};
  RuleList rules = {};

  ItemList(const std::vector<RuleElement>& elements, const std::vector<std::uint32_t>& numbers,
           bool default_allow) {
    rules.default_effect = default_allow;
    for (const auto number : numbers) {
      for (const auto& topic : elements[number].criteria->topics) {
        const auto next = static_cast<std::uint32_t>(items.size());
        rules.items.push_back({topic.text, next, elements[number].rule->allow});
        items.push_back({&elements[number], &topic});
      }
    }
  }
  const TopicItem* find(std::optional<std::uint32_t> number) const {
    return number ? &items[*number] : nullptr;
  }
};

// Returns the publish and subscribe elements of all rules up to the last deny_rule. Later rules
// need not be listed: they let a topic be created, and so does the default of the preceding list.
// If the grant's default denies, a topic that no rule names cannot be used anyway.
std::vector<RuleElement> preceding_elements(const RulePointers& rules) {
  std::vector<RuleElement> elements;
  std::size_t size = 0;
  for (const GrantRule* rule : rules) {
    for (const auto* list : {&rule->publish, &rule->subscribe})
      for (const auto& criteria : *list) elements.push_back({rule, &criteria});
    if (!rule->allow) size = elements.size();
  }
  elements.resize(size);
  return elements;
}

ItemList preceding_list(const std::vector<RuleElement>& elements) {
  std::vector<std::uint32_t> all(elements.size());
  std::iota(all.begin(), all.end(), 0U);
  return ItemList(elements, all, true);
}

// Removes items at the end that have the same effect as the default.
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

using TextPair = std::pair<const Text*, const Text*>;

// Class, the elements that decide, and all pairs of expressions.
using FoundChangeKey =
    std::tuple<ChangeClass, const Criteria*, const Criteria*, std::vector<TextPair>>;

// The change for entities of one kind by two elements.
struct FoundChange {
  PermissionChange change;
  std::vector<TopicPair> pairs = {};
  std::vector<TextPair> texts = {};
};

class OperationComparison {
 public:
  OperationComparison(const RuleSides& sides, const Operation& operation, const SetLimits& limits)
      : operation_(operation),
        old_grant_(sides.old_grant),
        new_grant_(sides.new_grant),
        old_default_(operation.has_default && sides.old_grant.default_allow),
        new_default_(operation.has_default && sides.new_grant.default_allow),
        limits_(limits),
        old_elements_(elements_of(sides.old_rules, operation.list)),
        new_elements_(elements_of(sides.new_rules, operation.list)) {
    if (!sides.first_rule_creates_topic || !operation.has_default) return;
    old_preceding_elements_ = preceding_elements(sides.old_rules);
    new_preceding_elements_ = preceding_elements(sides.new_rules);
    old_preceding_ = preceding_list(old_preceding_elements_);
    new_preceding_ = preceding_list(new_preceding_elements_);
  }

  OperationDiff run() {
    const auto contexts = entity_contexts(old_elements_, new_elements_, limits_);
    if (!contexts) {
      out_.is_known = false;
      return std::move(out_);
    }
    out_.is_exact = contexts->is_exact;
    for (std::size_t i = 0; i < contexts->contexts.size(); ++i)
      compare_context(contexts->contexts[i], i);
    for (auto& change : out_.changes) {
      const auto& numbers = contexts_of_[static_cast<std::size_t>(&change - out_.changes.data())];
      describe_entities(*contexts, numbers, change.entities);
    }
    return std::move(out_);
  }

 private:
  struct ItemDecision {
    const TopicItem* item;  // nullptr if the default decides
    bool allowed;
  };
  using ChangesByElements =
      std::map<std::tuple<ChangeClass, const Criteria*, const Criteria*>, FoundChange>;

  void compare_context(const EntityContext& context, std::size_t number) {
    const ItemList before(old_elements_, context.old_elements, old_default_);
    const ItemList after(new_elements_, context.new_elements, new_default_);
    if (same(before.rules, after.rules) && same(old_preceding_.rules, new_preceding_.rules)) return;
    ChangesByElements found;
    bool names_all_effects = true;
    if (old_preceding_.items.empty() && new_preceding_.items.empty()) {
      const auto pairs = topic_pairs(before.rules, after.rules, limits_);
      out_.is_complete = out_.is_complete && pairs.names_all_rules;
      names_all_effects = pairs.names_all_effects;
      for (const auto& pair : pairs.pairs)
        compare_pair(pair, decided(before, pair.old_rule, old_default_),
                     decided(after, pair.new_rule, new_default_), found);
    } else {
      names_all_effects = compare_preceded(before, after, found);
    }
    for (auto& [key, entry] : found) add(key, std::move(entry), before, after, number);
    if (!names_all_effects) give_up();
  }

  // False if a limit was reached.
  bool compare_preceded(const ItemList& before, const ItemList& after, ChangesByElements& found) {
    const auto pairs = preceded_pairs({before.rules, old_preceding_.rules},
                                      {after.rules, new_preceding_.rules}, limits_);
    if (!pairs) return false;
    for (const auto& [pair, old_preceding, new_preceding] : *pairs)
      compare_pair(pair,
                   effective_decision(decided(old_preceding_, old_preceding, true),
                                      decided(before, pair.old_rule, old_default_)),
                   effective_decision(decided(new_preceding_, new_preceding, true),
                                      decided(after, pair.new_rule, new_default_)),
                   found);
    return true;
  }

  static ItemDecision decided(const ItemList& list, std::optional<std::uint32_t> rule,
                              bool default_allow) {
    const auto* const item = list.find(rule);
    return {item, item != nullptr ? item->element->rule->allow : default_allow};
  }
  // The preceding list decides only if it alone denies. If both deny, the list's rule is named.
  static ItemDecision effective_decision(const ItemDecision& preceding, const ItemDecision& list) {
    return preceding.allowed || !list.allowed ? list : preceding;
  }

  void compare_pair(const TopicPair& pair, const ItemDecision& o, const ItemDecision& n,
                    ChangesByElements& found) {
    if (o.allowed == n.allowed) return;
    if (o.item == nullptr && n.item == nullptr) {
      out_.by_default.add(class_of(n.allowed));
      return;
    }
    const auto criteria = [](const TopicItem* item) {
      return item ? item->element->criteria : nullptr;
    };
    auto& entry = found[{class_of(n.allowed), criteria(o.item), criteria(n.item)}];
    if (entry.pairs.empty()) entry.change = change_at(pair, o.item, n.item, n.allowed);
    entry.pairs.push_back(pair);
    entry.texts.emplace_back(o.item ? o.item->topic : nullptr, n.item ? n.item->topic : nullptr);
  }

  PermissionChange change_at(const TopicPair& pair, const TopicItem* o, const TopicItem* n,
                             bool allowed) const {
    return {.element = "rule",
            .operation = operation_.name,
            .change = class_of(allowed),
            .old_value = std::string(verdict_word(!allowed)),
            .new_value = std::string(verdict_word(allowed)),
            .is_about_topics = true,
            .witness = pair.witness,
            .old_line = o ? o->topic->line : old_grant_.line,
            .new_line = n ? n->topic->line : new_grant_.line};
  }

  void add(const std::tuple<ChangeClass, const Criteria*, const Criteria*>& by, FoundChange found,
           const ItemList& before, const ItemList& after, std::size_t context) {
    const FoundChangeKey key(std::get<0>(by), std::get<1>(by), std::get<2>(by), found.texts);
    const auto [entry, is_new] = known_.try_emplace(key, out_.changes.size());
    if (is_new) {
      auto& change = out_.changes.emplace_back(std::move(found.change));
      change.topics = topics_in_words(before.rules, after.rules, found.pairs, limits_.shared);
      std::set<std::string_view> old_known, new_known;
      for (const auto& [o, n] : found.texts) {
        if (o && old_known.insert(o->text).second) change.expressions_old.push_back(o->text);
        if (n && new_known.insert(n->text).second) change.expressions_new.push_back(n->text);
      }
      contexts_of_.emplace_back();
    }
    contexts_of_[entry->second].push_back(context);
  }

  static void describe_entities(const EntityContexts& all, const std::vector<std::size_t>& numbers,
                                EntityWords& out) {
    const auto& first = all.contexts[numbers.front()];
    out.example_partitions = first.partitions;
    out.example_data_tags = first.data_tags;
    out.every = numbers.size() == all.contexts.size() && all.is_exact;
    std::vector<NameKinds::Kind> kinds;
    for (const auto number : numbers) {
      const auto& single = all.contexts[number].single_partitions;
      kinds.insert(kinds.end(), single.begin(), single.end());
    }
    std::ranges::sort(kinds);
    if (!kinds.empty()) out.partitions = all.partitions.describe(kinds);
  }

  void give_up() {
    out_.is_known = false;
    // Further differences that can be found quickly are still shown.
    limits_.states = std::min<std::size_t>(limits_.states, 2'000);
  }

  const Operation& operation_;
  const Grant& old_grant_;
  const Grant& new_grant_;
  bool old_default_, new_default_;
  SetLimits limits_;
  std::vector<RuleElement> old_elements_, new_elements_, old_preceding_elements_,
      new_preceding_elements_;
  ItemList old_preceding_{{}, {}, true}, new_preceding_{{}, {}, true};
  OperationDiff out_;
  std::map<FoundChangeKey, std::size_t> known_;        // indices into out_.changes
  std::vector<std::vector<std::size_t>> contexts_of_;  // the contexts of each change
};

}  // namespace

OperationDiff compare_operation(const RuleSides& sides, const Operation& operation,
                                const SetLimits& limits) {
  return OperationComparison(sides, operation, limits).run();
}

std::string_view verdict_word(bool allowed) { return allowed ? "allowed" : "denied"; }
ChangeClass class_of(bool allowed_now) {
  return allowed_now ? ChangeClass::wider : ChangeClass::narrower;
}

}  // namespace ddssec::governance
