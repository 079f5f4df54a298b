#include "governance/expression_table.hpp"

#include <algorithm>
#include <ranges>
#include <unordered_map>

namespace ddssec::governance {
namespace {

void separate(ByteClasses& classes, const Pattern& pattern) {
  if (pattern.is_literal()) {
    for (const char c : pattern.text()) classes.separate(static_cast<std::uint8_t>(c));
  }
  for (const auto& step : pattern.steps()) {
    if (step.kind == Pattern::Kind::character) classes.separate(step.character);
    if (step.kind == Pattern::Kind::set) classes.separate(pattern.set_of(step));
  }
}

std::vector<std::uint32_t> classes_in(const std::bitset<256>& set, const ByteClasses& classes) {
  std::vector<std::uint32_t> in;
  for (ByteClasses::Class c = 0; c < classes.size(); ++c) {
    if (set.test(static_cast<std::uint8_t>(classes.shown(c)))) in.push_back(c);
  }
  return in;
}

void sort_unique(auto& list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

ExpressionTable::ExpressionTable(std::span<const RankedExpression> expressions) {
  number_labels(expressions);
  std::unordered_map<std::string_view, std::size_t> known;
  std::vector<Pattern> patterns;
  std::vector<std::vector<Label>> labels;
  for (const auto& item : expressions) {
    const auto [entry, is_new] = known.try_emplace(item.expression, patterns.size());
    if (is_new) {
      patterns.emplace_back(item.expression);
      labels.emplace_back();
      separate(classes_, patterns.back());
    }
    const auto label = std::ranges::lower_bound(labels_, NameAtom::Match{item.list, item.rank});
    labels[entry->second].push_back(static_cast<Label>(label - labels_.begin()));
  }
  classes_.number();
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    keep_first_of_each_list(labels[i]);
    beginnings_.push_back(lay_out(patterns[i], label_sets_.add(labels[i]).first));
  }
  sort_unique(beginnings_);
}

void ExpressionTable::number_labels(std::span<const RankedExpression> expressions) {
  labels_.reserve(expressions.size());
  for (const auto& item : expressions) labels_.push_back({item.list, item.rank});
  sort_unique(labels_);
  for (const auto& label : labels_) {
    const auto i = list_numbers_.size();
    list_numbers_.push_back(i == 0 ? 0
                                   : list_numbers_[i - 1] + (labels_[i - 1].list != label.list));
  }
}

ExpressionTable::Position ExpressionTable::lay_out(const Pattern& pattern, NumberLists::Id labels) {
  Position at = end_of(labels);
  if (pattern.is_literal()) {
    for (const char c : std::views::reverse(pattern.text())) {
      at = put_before(at, Kind::octet, classes_.of(static_cast<std::uint8_t>(c)));
    }
  }
  for (const auto& step : std::views::reverse(pattern.steps())) at = put_before(at, pattern, step);
  return at;
}

ExpressionTable::Position ExpressionTable::end_of(NumberLists::Id labels) {
  const std::uint32_t key[] = {static_cast<std::uint32_t>(Kind::end), labels, kNone};
  const auto [position, is_new] = known_steps_.add(key);
  if (is_new) steps_.push_back({Kind::end, 0, kNone, labels, kNone, kNone});
  return position;
}

ExpressionTable::Position ExpressionTable::put_before(Position next, Kind kind,
                                                      std::uint32_t value) {
  const std::uint32_t key[] = {static_cast<std::uint32_t>(kind), value, next};
  const auto [position, is_new] = known_steps_.add(key);
  if (!is_new) return position;
  const Position ahead = steps_[next].kind == Kind::star ? next : steps_[next].star_ahead;
  steps_.push_back({kind, value, next, steps_[next].labels, kNone, ahead});
  if (kind == Kind::star) steps_[next].star_before = position;
  return position;
}

ExpressionTable::Position ExpressionTable::put_before(Position next, const Pattern& pattern,
                                                      const Pattern::Step& step) {
  switch (step.kind) {
    case Pattern::Kind::character:
      return put_before(next, Kind::octet, classes_.of(step.character));
    case Pattern::Kind::any:
      return put_before(next, Kind::any, 0);
    case Pattern::Kind::star:
      return put_before(next, Kind::star, 0);
    case Pattern::Kind::set:
      break;
  }
  const auto set = sets_.add(classes_in(pattern.set_of(step), classes_)).first;
  return put_before(next, Kind::set, set);
}

void ExpressionTable::keep_first_of_each_list(std::vector<Label>& labels) const {
  std::ranges::sort(labels);
  const auto same_list = [this](Label a, Label b) { return match(a).list == match(b).list; };
  labels.erase(std::unique(labels.begin(), labels.end(), same_list), labels.end());
}

}  // namespace ddssec::governance
