#include "governance/compare/expression_table.hpp"

#include <algorithm>
#include <unordered_map>

namespace ddssec::governance {
namespace {

void tell_apart(ByteClasses& classes, const Pattern& pattern) {
  if (pattern.is_literal()) {
    for (const char c : pattern.text()) classes.tell_apart(static_cast<std::uint8_t>(c));
  }
  for (const auto& step : pattern.steps()) {
    if (step.kind == Pattern::Kind::character) classes.tell_apart(step.character);
    if (step.kind == Pattern::Kind::set) classes.tell_apart(pattern.set_of(step));
  }
}

std::vector<ByteClasses::Class> classes_in(const std::bitset<256>& set,
                                           const ByteClasses& classes) {
  std::vector<ByteClasses::Class> in;
  for (ByteClasses::Class c = 0; c < classes.size(); ++c) {
    if (set.test(static_cast<std::uint8_t>(classes.shown(c)))) in.push_back(c);
  }
  return in;
}

}  // namespace

ExpressionTable::ExpressionTable(std::span<const RankedExpression> expressions) {
  number_labels(expressions);
  std::unordered_map<std::string_view, Expression> known;
  std::vector<Pattern> patterns;
  for (const auto& item : expressions) {
    const auto next = static_cast<Expression>(patterns.size());
    const auto [entry, is_new] = known.try_emplace(item.expression, next);
    if (is_new) {
      patterns.emplace_back(item.expression);
      labels_of_.emplace_back();
      tell_apart(classes_, patterns.back());
    }
    const auto label = std::ranges::lower_bound(labels_, NameAtom::Match{item.list, item.rank});
    labels_of_[entry->second].push_back(static_cast<Label>(label - labels_.begin()));
  }
  classes_.number();
  for (const auto& pattern : patterns) lay_out(pattern);
  for (auto& labels : labels_of_) keep_first_of_each_list(labels);
}

void ExpressionTable::number_labels(std::span<const RankedExpression> expressions) {
  labels_.reserve(expressions.size());
  for (const auto& item : expressions) labels_.push_back({item.list, item.rank});
  std::ranges::sort(labels_);
  labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
}

void ExpressionTable::lay_out(const Pattern& pattern) {
  const auto expression = static_cast<Expression>(beginnings_.size());
  beginnings_.push_back(static_cast<Position>(steps_.size()));
  if (pattern.is_literal()) {
    for (const char c : pattern.text()) {
      steps_.push_back({Kind::octet, classes_.of(static_cast<std::uint8_t>(c)), 0, expression});
    }
  }
  for (const auto& step : pattern.steps()) lay_out(pattern, step, expression);
  steps_.push_back({Kind::end, 0, 0, expression});
}

void ExpressionTable::lay_out(const Pattern& pattern, const Pattern::Step& step,
                              Expression expression) {
  switch (step.kind) {
    case Pattern::Kind::character:
      steps_.push_back({Kind::octet, classes_.of(step.character), 0, expression});
      break;
    case Pattern::Kind::any:
      steps_.push_back({Kind::any, 0, 0, expression});
      break;
    case Pattern::Kind::star:
      steps_.push_back({Kind::star, 0, 0, expression});
      break;
    case Pattern::Kind::set:
      steps_.push_back({Kind::set, 0, static_cast<std::uint32_t>(sets_.size()), expression});
      sets_.push_back(classes_in(pattern.set_of(step), classes_));
      break;
  }
}

void ExpressionTable::keep_first_of_each_list(std::vector<Label>& labels) const {
  std::ranges::sort(labels);
  const auto same_list = [this](Label a, Label b) { return match(a).list == match(b).list; };
  labels.erase(std::unique(labels.begin(), labels.end(), same_list), labels.end());
}

bool ExpressionTable::is_settled(Expression e, std::span<const Label> forever) const {
  return std::ranges::all_of(labels_of_[e], [&](Label label) {
    // Labels ascend by list and then rank: the last one not above this one decides.
    const auto above = std::ranges::upper_bound(forever, label);
    return above != forever.begin() && match(*(above - 1)).list == match(label).list;
  });
}

}  // namespace ddssec::governance
