#include "governance/compare/partition_contexts.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {
namespace {

constexpr std::size_t kMostContexts = 4096;

/// Names of partitions that no expression tells apart.
struct PartitionKind {
  std::string example;
  std::vector<bool> matched_by;  ///< for each expression
};

using Numbers = std::map<std::string_view, std::uint32_t>;  ///< of expressions

/// "" has number 0, since rules without partitions speak of it.
Numbers number_expressions(std::span<const RuleElement> old_elements,
                           std::span<const RuleElement> new_elements) {
  Numbers numbers = {{"", 0}};
  for (const auto& elements : {old_elements, new_elements}) {
    for (const auto& element : elements) {
      if (!element.criteria->partitions) continue;
      for (const auto& text : *element.criteria->partitions) {
        numbers.try_emplace(text.text, static_cast<std::uint32_t>(numbers.size()));
      }
    }
  }
  return numbers;
}

std::optional<std::vector<PartitionKind>> kinds_of(const Numbers& numbers) {
  std::vector<RankedExpression> own;
  for (const auto& [text, number] : numbers) own.push_back({text, number, 0});
  auto atoms = name_atoms(own);
  if (!atoms) return std::nullopt;
  std::vector<PartitionKind> kinds;
  for (auto& atom : *atoms) {
    std::vector<bool> matched_by(numbers.size());
    for (const auto& match : atom.matches) matched_by[match.list] = true;
    kinds.push_back({std::move(atom.witness), std::move(matched_by)});
  }
  // The default partition, which is a kind of its own, comes first.
  const auto usual =
      std::ranges::find_if(kinds, [](const PartitionKind& kind) { return kind.matched_by[0]; });
  std::rotate(kinds.begin(), usual, usual + 1);
  return kinds;
}

class ContextFinder {
 public:
  ContextFinder(std::span<const RuleElement> old_elements,
                std::span<const RuleElement> new_elements, const Numbers& numbers,
                std::vector<PartitionKind> kinds)
      : old_(listed(old_elements, numbers)),
        new_(listed(new_elements, numbers)),
        kinds_(std::move(kinds)) {}

  PartitionContexts run() {
    if (kinds_.size() <= kMostExactPartitions) {
      const unsigned end = 1u << kinds_.size();
      for (unsigned set = 1; set < end; ++set) {
        std::vector<std::size_t> members;
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
          if ((set >> i & 1) != 0) members.push_back(i);
        }
        try_set(members);
      }
      return std::move(result_);
    }
    result_.is_exact = false;
    for (std::size_t i = 0; i < kinds_.size(); ++i) try_set({i});
    std::size_t tries = 0;
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      for (std::size_t j = i + 1; j < kinds_.size() && ++tries < kMostContexts; ++j) {
        try_set({i, j});
      }
    }
    return std::move(result_);
  }

 private:
  /// An element with its partitions as numbers.
  struct Element {
    bool allow;
    bool has_partitions;
    bool has_data_tags;
    std::vector<std::uint32_t> partitions;
  };

  static std::vector<Element> listed(std::span<const RuleElement> elements,
                                     const Numbers& numbers) {
    std::vector<Element> result;
    for (const auto& [rule, criteria] : elements) {
      Element element{
          rule->allow, criteria->partitions.has_value(), criteria->data_tags.has_value(), {}};
      if (criteria->partitions) {
        for (const auto& text : *criteria->partitions) {
          element.partitions.push_back(numbers.at(text.text));
        }
      }
      result.push_back(std::move(element));
    }
    return result;
  }

  bool lists(const Element& element, std::size_t kind) const {
    const auto& matched_by = kinds_[kind].matched_by;
    if (!element.has_partitions) return matched_by[0];
    return std::ranges::any_of(element.partitions, [&](auto number) { return matched_by[number]; });
  }

  bool fits(const Element& element, const std::vector<std::size_t>& set) const {
    const auto is_listed = [&](std::size_t kind) { return lists(element, kind); };
    if (element.allow) return std::ranges::all_of(set, is_listed);
    // A deny rule with data tags is about entities that have one of them.
    if (element.has_data_tags) return false;
    return !element.has_partitions || std::ranges::any_of(set, is_listed);
  }

  std::vector<std::uint32_t> fitting(const std::vector<Element>& elements,
                                     const std::vector<std::size_t>& set) const {
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < elements.size(); ++i) {
      if (fits(elements[i], set)) numbers.push_back(i);
    }
    return numbers;
  }

  void try_set(const std::vector<std::size_t>& set) {
    auto old_elements = fitting(old_, set), new_elements = fitting(new_, set);
    if (!known_.emplace(old_elements, new_elements).second) return;
    PartitionContext context{{}, std::move(old_elements), std::move(new_elements)};
    for (const auto kind : set) context.partitions.push_back(kinds_[kind].example);
    result_.contexts.push_back(std::move(context));
  }

  std::vector<Element> old_, new_;
  std::vector<PartitionKind> kinds_;
  std::set<std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>>> known_;
  PartitionContexts result_;
};

}  // namespace

std::optional<PartitionContexts> partition_contexts(std::span<const RuleElement> old_elements,
                                                    std::span<const RuleElement> new_elements) {
  const auto numbers = number_expressions(old_elements, new_elements);
  auto kinds = kinds_of(numbers);
  if (!kinds) return std::nullopt;
  return ContextFinder(old_elements, new_elements, numbers, std::move(*kinds)).run();
}

}  // namespace ddssec::governance
