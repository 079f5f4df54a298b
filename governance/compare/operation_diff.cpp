#include "governance/compare/operation_diff.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <tuple>

#include "governance/compare/entity_contexts.hpp"
#include "governance/compare/topic_pairs.hpp"

namespace ddssec::governance {
namespace {

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

/// The expressions of the elements that entities can meet, in order, as a list of rules.
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

/// Removes items at the end that have the same effect as the default.
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

/// Class, the elements that decide, and all pairs of expressions.
using FoundKey = std::tuple<ChangeClass, const Criteria*, const Criteria*, std::vector<TextPair>>;

/// The change for entities of one kind by two elements.
struct Found {
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
        new_elements_(elements_of(sides.new_rules, operation.list)) {}

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
  void compare_context(const EntityContext& context, std::size_t number) {
    const ItemList before(old_elements_, context.old_elements, old_default_);
    const ItemList after(new_elements_, context.new_elements, new_default_);
    if (same(before.rules, after.rules)) return;
    const auto pairs = topic_pairs(before.rules, after.rules, limits_);
    out_.is_complete = out_.is_complete && pairs.names_all_rules;
    std::map<std::tuple<ChangeClass, const Criteria*, const Criteria*>, Found> found;
    for (const auto& pair : pairs.pairs) {
      const auto *o = before.find(pair.old_rule), *n = after.find(pair.new_rule);
      const bool was = o ? o->element->rule->allow : old_default_;
      const bool is = n ? n->element->rule->allow : new_default_;
      if (was == is) continue;
      if (!o && !n) {
        out_.by_default.add(class_of(is));
        continue;
      }
      const auto criteria = [](const TopicItem* item) {
        return item ? item->element->criteria : nullptr;
      };
      auto& entry = found[{class_of(is), criteria(o), criteria(n)}];
      if (entry.pairs.empty()) entry.change = change_at(pair, o, n, is);
      entry.pairs.push_back(pair);
      entry.texts.emplace_back(o ? o->topic : nullptr, n ? n->topic : nullptr);
    }
    for (auto& [key, entry] : found) add(key, std::move(entry), before, after, number);
    if (!pairs.names_all_effects) give_up();
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

  void add(const std::tuple<ChangeClass, const Criteria*, const Criteria*>& by, Found found,
           const ItemList& before, const ItemList& after, std::size_t context) {
    const FoundKey key(std::get<0>(by), std::get<1>(by), std::get<2>(by), found.texts);
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
  std::vector<RuleElement> old_elements_, new_elements_;
  OperationDiff out_;
  std::map<FoundKey, std::size_t> known_;              ///< where in out_.changes
  std::vector<std::vector<std::size_t>> contexts_of_;  ///< of each change
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
