#include "governance/compare/entity_contexts.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace ddssec::governance {
namespace {

// For each element: true if the entity's partitions (or tags) match it. For deny rules the values
// are inverted, so that two such vectors are combined by "and".
using Matches = std::vector<bool>;

Matches both(const Matches& a, const Matches& b) {
  Matches out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] && b[i];
  return out;
}

// A set of an entity's partitions or tags, by number.
struct NumberSet {
  std::vector<std::uint32_t> numbers;
  Matches matches;
};

// The match results of all sets, each result once with the smallest set.
class Closure {
 public:
  Closure(std::vector<Matches> singles, SetEffort& effort)
      : singles_(std::move(singles)), effort_(effort) {}

  void begin_with(NumberSet first) { add(std::move(first)); }

  // Finds all results. False if there are more than kMaxContexts, or more than the effort allows.
  bool run() {
    for (std::uint32_t i = 0; i < singles_.size() && may_continue(); ++i) add({{i}, singles_[i]});
    for (std::size_t at = 0; at < all_.size() && may_continue(); ++at) {
      for (std::uint32_t i = 0; i < singles_.size() && may_continue(); ++i) {
        is_paid_ = effort_.take_plain_steps(singles_[i].size() + all_[at].numbers.size());
        NumberSet more{all_[at].numbers, both(all_[at].matches, singles_[i])};
        if (known_.contains(more.matches)) continue;
        more.numbers.push_back(i);
        add(std::move(more));
      }
    }
    const bool is_complete = may_continue();
    if (all_.size() > kMaxContexts) all_.resize(kMaxContexts);
    return is_complete;
  }
  std::vector<NumberSet> take() { return std::move(all_); }

 private:
  void add(NumberSet set) {
    if (known_.insert(set.matches).second) all_.push_back(std::move(set));
  }

  bool may_continue() const { return is_paid_ && all_.size() <= kMaxContexts; }

  std::vector<Matches> singles_;
  SetEffort& effort_;
  bool is_paid_ = true;
  std::set<Matches> known_;
  std::vector<NumberSet> all_;
};

class ContextFinder {
 public:
  ContextFinder(std::span<const RuleElement> old_elements,
                std::span<const RuleElement> new_elements, NameKinds partitions, SetEffort& effort)
      : old_count_(old_elements.size()), effort_(effort), out_{std::move(partitions)} {
    elements_.assign(old_elements.begin(), old_elements.end());
    elements_.insert(elements_.end(), new_elements.begin(), new_elements.end());
    for (const auto& element : elements_) {
      auto& numbers = partition_numbers_.emplace_back();
      if (element.criteria->partitions) {
        for (const auto& text : *element.criteria->partitions)
          numbers.push_back(out_.partitions.number_of(text.text));
      }
      if (element.criteria->data_tags)
        tags_.insert(tags_.end(), element.criteria->data_tags->begin(),
                     element.criteria->data_tags->end());
    }
    std::ranges::sort(tags_);
    const auto repeated = std::ranges::unique(tags_);
    tags_.erase(repeated.begin(), repeated.end());
    // A tag that no element lists also matters: allow rules do not match it, and deny rules without
    // tags do.
    tags_.push_back(unlisted_tag());
  }

  // Empty if the effort does not even suffice for single partitions and tags.
  std::optional<EntityContexts> run() {
    if (!effort_.take_plain_steps(cost_of_singles())) return std::nullopt;
    const auto with_partitions = partition_sets();
    const auto with_tags = tag_sets();
    for (const auto& tags : with_tags) {
      for (const auto& partitions : with_partitions) {
        const bool is_paid = effort_.take_plain_steps(elements_.size() + 1);
        if (is_paid) add(partitions, tags);
        if (!is_paid || out_.contexts.size() > kMaxContexts) {
          out_.is_exact = false;
          return std::move(out_);
        }
      }
    }
    note_single_partitions();
    return std::move(out_);
  }

 private:
  // Every kind of partition and every data tag is compared with what every element lists, and once
  // more for the description.
  std::size_t cost_of_singles() const {
    std::size_t listed = elements_.size();
    for (const auto& numbers : partition_numbers_) listed += numbers.size();
    std::size_t listed_tags = elements_.size();
    for (const auto& element : elements_)
      if (element.criteria->data_tags) listed_tags += element.criteria->data_tags->size();
    return 2 * (out_.partitions.size() * listed + tags_.size() * listed_tags);
  }

  bool lists(std::size_t element, NameKinds::Kind kind) const {
    if (!elements_[element].criteria->partitions) return kind == 0;
    return std::ranges::any_of(partition_numbers_[element], [&](std::size_t number) {
      return out_.partitions.matches(number, kind);
    });
  }

  Matches matches_of_partition(NameKinds::Kind kind) const {
    Matches out;
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      const auto& [rule, criteria] = elements_[i];
      out.push_back(rule->allow ? lists(i, kind) : criteria->partitions && !lists(i, kind));
    }
    return out;
  }

  Matches matches_of_tag(const DataTag& tag) const {
    Matches out;
    for (const auto& [rule, criteria] : elements_) {
      const bool listed = criteria->data_tags && std::ranges::find(*criteria->data_tags, tag) !=
                                                     criteria->data_tags->end();
      out.push_back(rule->allow ? listed : criteria->data_tags && !listed);
    }
    return out;
  }

  // An entity without data tags does not match a deny rule that lists some.
  Matches matches_of_no_tag() const {
    Matches out;
    for (const auto& [rule, criteria] : elements_)
      out.push_back(rule->allow || criteria->data_tags.has_value());
    return out;
  }

  // A tag that no element lists.
  DataTag unlisted_tag() const {
    DataTag tag{"other", "other"};
    while (std::ranges::binary_search(tags_, tag)) tag.name += '_';
    return tag;
  }

  std::vector<NumberSet> partition_sets() {
    std::vector<Matches> singles;
    for (NameKinds::Kind kind = 0; kind < out_.partitions.size(); ++kind)
      singles.push_back(matches_of_partition(kind));
    Closure closure(std::move(singles), effort_);
    if (!closure.run()) out_.is_exact = false;
    return closure.take();
  }

  std::vector<NumberSet> tag_sets() {
    std::vector<Matches> singles;
    for (const auto& tag : tags_) singles.push_back(matches_of_tag(tag));
    Closure closure(std::move(singles), effort_);
    closure.begin_with({{}, matches_of_no_tag()});
    if (!closure.run()) out_.is_exact = false;
    return closure.take();
  }

  // The numbers of the elements that match in both respects.
  std::vector<std::uint32_t> fitting(const Matches& partitions, const Matches& tags) const {
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < elements_.size(); ++i) {
      const bool allow = elements_[i].rule->allow;
      if (partitions[i] == allow && tags[i] == allow) out.push_back(i);
    }
    return out;
  }

  void add(const NumberSet& partitions, const NumberSet& tags) {
    auto fitting = this->fitting(partitions.matches, tags.matches);
    const auto [entry, is_new] = known_.try_emplace(fitting, out_.contexts.size());
    if (!is_new) return;
    EntityContext context;
    for (const auto kind : partitions.numbers)
      context.partitions.push_back(out_.partitions.example(kind));
    for (const auto tag : tags.numbers) context.data_tags.push_back(tags_[tag]);
    for (const auto element : fitting) {
      const bool is_old = element < old_count_;
      auto& list = is_old ? context.old_elements : context.new_elements;
      list.push_back(is_old ? element : element - static_cast<std::uint32_t>(old_count_));
    }
    out_.contexts.push_back(std::move(context));
  }

  void note_single_partitions() {
    const auto no_tag = matches_of_no_tag();
    for (NameKinds::Kind kind = 0; kind < out_.partitions.size(); ++kind) {
      const auto found = known_.find(fitting(matches_of_partition(kind), no_tag));
      if (found != known_.end()) out_.contexts[found->second].single_partitions.push_back(kind);
    }
  }

  std::size_t old_count_;
  SetEffort& effort_;
  EntityContexts out_;
  std::vector<RuleElement> elements_;
  std::vector<std::vector<std::size_t>> partition_numbers_;  // expressions of each element
  std::vector<DataTag> tags_;
  std::map<std::vector<std::uint32_t>, std::size_t> known_;
};

}  // namespace

std::optional<EntityContexts> entity_contexts(std::span<const RuleElement> old_elements,
                                              std::span<const RuleElement> new_elements,
                                              const SetLimits& limits) {
  std::vector<std::string> expressions;
  for (const auto& elements : {old_elements, new_elements}) {
    for (const auto& element : elements) {
      if (!element.criteria->partitions) continue;
      for (const auto& text : *element.criteria->partitions) expressions.push_back(text.text);
    }
  }
  auto partitions = NameKinds::of(std::move(expressions), limits);
  if (!partitions) return std::nullopt;
  SetEffort own{limits.steps};
  auto& effort = limits.shared != nullptr ? *limits.shared : own;
  return ContextFinder(old_elements, new_elements, *std::move(partitions), effort).run();
}

}  // namespace ddssec::governance
