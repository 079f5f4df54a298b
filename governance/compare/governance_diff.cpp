#include "governance/compare/governance_diff.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include "base/stable_sort.hpp"
#include "governance/compare/comparison_effort.hpp"
#include "governance/compare/stock_changes.hpp"
#include "governance/compare/topic_pairs.hpp"
#include "governance/product_reading.hpp"

namespace ddssec::governance {
namespace {

using SharedDocument = std::shared_ptr<const Governance>;
using SharedRule = std::shared_ptr<const DomainRule>;

// The rule as a part of its document, which lives as long as the result.
SharedRule part_of(const SharedDocument& document, const DomainRule* rule) {
  return rule ? SharedRule(document, rule) : nullptr;
}

// The two rules that apply in a region; nullptr if there is none.
using DomainRules = std::pair<const DomainRule*, const DomainRule*>;

// Returns one topic rule's values as a number; 0 is kept for "no rule".
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

// The number of kinds of topics that lose or gain a property, and one of these topics.
struct Count {
  std::size_t topics = 0;
  std::string witness = {};
};

// The properties that change because of one element of a domain rule, topic by topic.
class DomainEffect {
 public:
  explicit DomainEffect(std::string_view element) : element_(element) {}

  void add(const Protection& before, const Protection& after, const std::string& witness) {
    ++topics_;
    const auto [lost, gained] = governance::effect_of(element_, before, after);
    lost_ |= lost;
    gained_ |= gained;
    for (const auto property : listed(lost | gained)) {
      auto& count = counts_[property];
      if (count.topics++ == 0) count.witness = witness;
    }
  }

  void fill(GovernanceChange& change) const {
    change.lost = lost_;
    change.gained = gained_;
    for (const auto& [property, count] : counts_)
      if (count.topics < topics_) change.of_some.push_back({property, count.witness});
  }

 private:
  std::string_view element_;
  std::size_t topics_ = 0;
  Properties lost_, gained_;
  std::map<ProtectionProperty, Count> counts_;
};

// Element, both values, class, properties lost and gained.
using TopicChangeKey =
    std::tuple<std::string_view, std::string, std::string, ChangeClass, std::string>;

// The position of a change in the result, and its topics.
struct KnownChange {
  std::size_t index;
  std::vector<TopicPair> pairs = {};
  std::set<std::string_view> old_expressions = {}, new_expressions = {};
};

// The comparison of two rules in the region where they apply.
class RegionComparison {
 public:
  RegionComparison(const SharedRule& old_rule, const SharedRule& new_rule, const DomainScope& scope,
                   std::vector<GovernanceChange>& changes)
      : shared_old_(old_rule),
        shared_new_(new_rule),
        old_(*old_rule),
        new_(*new_rule),
        scope_(scope),
        changes_(changes),
        domain_changes_(compare_domain_rules(&old_, &new_)),
        effects_(domain_changes_.size(), DomainEffect("")) {
    for (std::size_t i = 0; i < domain_changes_.size(); ++i)
      effects_[i] = DomainEffect(domain_changes_[i].element);
  }

  bool is_the_same() const { return domain_changes_.empty() && same_rules(old_, new_); }

  TopicPairs run(const std::vector<std::string>& topics, const SetLimits& limits) {
    const auto old_list = rule_list(old_), new_list = rule_list(new_);
    auto pairs = topics.empty() ? topic_pairs(old_list, new_list, limits)
                                : pairs_of_names(topics, old_list, new_list, limits);
    for (const auto& pair : pairs.pairs) compare_topic(pair);
    for (const auto& [key, known] : known_)
      changes_[known.index].topics =
          topics_in_words(old_list, new_list, known.pairs, limits.shared);
    for (std::size_t i = 0; i < domain_changes_.size(); ++i) {
      GovernanceChange change{.scope = scope_,
                              .element = domain_changes_[i],
                              .old_domain = shared_old_,
                              .new_domain = shared_new_};
      effects_[i].fill(change);
      changes_.push_back(std::move(change));
    }
    return pairs;
  }

  bool any_topic_change() const { return !known_.empty(); }

 private:
  static std::shared_ptr<const TopicRule> part_of(const SharedRule& rule, const TopicRule* topic) {
    return topic ? std::shared_ptr<const TopicRule>(rule, topic) : nullptr;
  }

  void compare_topic(const TopicPair& pair) {
    const auto* o = pair.old_rule ? &old_.topic_rules[*pair.old_rule] : nullptr;
    const auto* n = pair.new_rule ? &new_.topic_rules[*pair.new_rule] : nullptr;
    if (!o && !n) return;
    const auto elements = compare_topic_rules({old_, new_, o, n});
    const auto before = o && n ? Protection::of(old_, *o) : Protection{};
    const auto after = o && n ? Protection::of(new_, *n) : Protection{};
    if (o && n)
      for (auto& effect : effects_) effect.add(before, after, pair.witness);
    for (const auto& element : elements) {
      GovernanceChange change{.scope = scope_,
                              .element = element,
                              .is_about_topics = true,
                              .witness = pair.witness,
                              .old_domain = shared_old_,
                              .new_domain = shared_new_,
                              .old_topic = part_of(shared_old_, o),
                              .new_topic = part_of(shared_new_, n)};
      const auto effect = governance::effect_of(element.element, before, after);
      change.lost = effect.lost;
      change.gained = effect.gained;
      add(pair, std::move(change));
    }
  }

  void add(const TopicPair& pair, GovernanceChange change) {
    const auto& e = change.element;
    const auto key = std::tuple(e.element, e.old_value, e.new_value, e.change,
                                change.lost.to_string() + change.gained.to_string());
    const auto o = change.old_topic, n = change.new_topic;
    const auto [entry, is_new] = known_.try_emplace(key, KnownChange{changes_.size()});
    if (is_new) changes_.push_back(std::move(change));
    auto& known = entry->second;
    known.pairs.push_back(pair);
    auto& told = changes_[known.index];
    if (o && known.old_expressions.insert(o->topic_expression).second)
      told.expressions_old.push_back(o->topic_expression);
    if (n && known.new_expressions.insert(n->topic_expression).second)
      told.expressions_new.push_back(n->topic_expression);
  }

  const SharedRule &shared_old_, &shared_new_;
  const DomainRule& old_;
  const DomainRule& new_;
  const DomainScope& scope_;
  std::vector<GovernanceChange>& changes_;
  std::vector<ElementChange> domain_changes_;
  std::vector<DomainEffect> effects_;  // the effect of each domain change
  std::map<TopicChangeKey, KnownChange> known_;
};

class GovernanceComparison {
 public:
  GovernanceComparison(const SharedDocument& old_document, const SharedDocument& new_document,
                       const GovernanceDiffOptions& options)
      : shared_old_(old_document),
        shared_new_(new_document),
        old_(*old_document),
        new_(*new_document),
        options_(options),
        limits_(options.limits.sharing(effort_)) {}

  GovernanceDiff run() {
    if (const auto space = domain_space()) {
      const auto regions = space->regions([&](DomainId id, const std::string& tag) {
        return DomainRules(old_.find(id, tag), new_.find(id, tag));
      });
      for (const auto& region : regions) compare_in(region);
    } else {
      is_unknown_ = true;
      diff_.unknown_domains.push_back({0, kMaxGovernedDomainId});
    }
    finish();
    diff_.interpretations = interpretations_of(old_, new_);
    return std::move(diff_);
  }

 private:
  std::optional<DomainSpace> domain_space() const {
    std::vector<const DomainSet*> sets;
    for (const Governance* document : {&old_, &new_})
      for (const auto& rule : document->domain_rules) sets.push_back(&rule.domains);
    return DomainSpace::of(sets);
  }

  void compare_in(const DomainRegion<DomainRules>& region) {
    const auto [o, n] = region.answer;
    if (!o && !n) return;
    const auto shared_old = part_of(shared_old_, o), shared_new = part_of(shared_new_, n);
    if (!o || !n) {
      for (auto& element : compare_domain_rules(o, n))
        diff_.changes.push_back({.scope = region.scope,
                                 .element = element,
                                 .old_domain = shared_old,
                                 .new_domain = shared_new});
      return;
    }
    RegionComparison comparison(shared_old, shared_new, region.scope, diff_.changes);
    if (comparison.is_the_same()) return;
    const auto pairs = comparison.run(options_.topics, limits_);
    diff_.complete = diff_.complete && pairs.names_all_rules;
    if (pairs.names_all_effects) {
      if (!comparison.any_topic_change() && !same_rules(*o, *n)) note_rewritten(region);
      return;
    }
    is_unknown_ = true;
    const auto& domains = region.scope.domains;
    diff_.unknown_domains.insert(diff_.unknown_domains.end(), domains.begin(), domains.end());
    // Further differences that can be found quickly are still shown.
    limits_.states = std::min<std::size_t>(limits_.states, 2'000);
  }

  void note_rewritten(const DomainRegion<DomainRules>& region) {
    const auto missing = [](const DomainRule& from, const DomainRule& in) {
      std::set<std::string_view> known;
      for (const auto& rule : in.topic_rules) known.insert(rule.topic_expression);
      std::vector<std::string> texts;
      for (const auto& rule : from.topic_rules)
        if (known.insert(rule.topic_expression).second) texts.push_back(rule.topic_expression);
      return texts;
    };
    const auto [o, n] = region.answer;
    diff_.rewritten.push_back({region.scope, missing(*o, *n), missing(*n, *o)});
  }

  // The verdict and the exit code follow from the lines.
  void finish() {
    CombinedChange direction;
    if (is_unknown_) direction.add(ChangeClass::unknown);
    for (const auto& change : diff_.changes) {
      direction.add(change.element.change);
      if (change.element.interop == Interop::none) continue;
      diff_.parts_participants |= change.element.interop == Interop::participant;
      const auto& domains = change.scope.domains;
      diff_.flag_day_domains.insert(diff_.flag_day_domains.end(), domains.begin(), domains.end());
    }
    diff_.verdict = direction.change_class(ChangeClass::stronger, ChangeClass::weaker);
    diff_.flag_day_domains = joined(std::move(diff_.flag_day_domains));
    diff_.unknown_domains = joined(std::move(diff_.unknown_domains));
    stable_sort_descending_by(diff_.changes, [](const GovernanceChange& change) {
      return std::pair(change.element.change, !change.is_about_topics);
    });
  }

  const SharedDocument &shared_old_, &shared_new_;
  const Governance& old_;
  const Governance& new_;
  const GovernanceDiffOptions& options_;
  SetEffort effort_ = kEffortOfComparison;
  SetLimits limits_;
  GovernanceDiff diff_;
  bool is_unknown_ = false;
};

int line_of(const SharedRule& domain, const std::shared_ptr<const TopicRule>& topic) {
  return topic ? topic->line : domain ? domain->line : 0;
}

// The document as the product reads it; the document itself if that changes nothing.
SharedDocument document_for(const SharedDocument& document, StockProduct product) {
  auto read = rewritten_for(*document, product);
  return read ? std::make_shared<const Governance>(std::move(*read)) : document;
}

}  // namespace

int GovernanceChange::old_line() const { return line_of(old_domain, old_topic); }
int GovernanceChange::new_line() const { return line_of(new_domain, new_topic); }

GovernanceDiff compare(const Governance& old_document, const Governance& new_document,
                       const GovernanceDiffOptions& options) {
  const auto before = std::make_shared<const Governance>(old_document);
  const auto after = std::make_shared<const Governance>(new_document);
  auto out = GovernanceComparison(before, after, options).run();
  std::vector<StockGovernanceDiff> stock;
  for (const auto product : kStockProducts) {
    const auto old_read = document_for(before, product), new_read = document_for(after, product);
    if (old_read != before || new_read != after)
      stock.push_back({product, GovernanceComparison(old_read, new_read, options).run()});
  }
  add_stock_changes(stock, out);
  return out;
}

}  // namespace ddssec::governance
