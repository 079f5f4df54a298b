#include "governance/compare/topic_words.hpp"

#include <algorithm>

namespace ddssec::governance {
namespace {

using Rule = std::optional<std::uint32_t>;

// The limits for finding out which of two expressions matches less.
constexpr SetLimits kLimits = {.states = 2'000, .steps = 1'000'000};
// The largest numbers of earlier rules that are examined for exceptions, and of exceptions that are
// named.
constexpr std::size_t kMaxEarlier = 64;
constexpr std::size_t kMaxExceptions = 3;

SetLimits limits_with(SetEffort* effort) {
  auto limits = kLimits;
  limits.shared = effort;
  return limits;
}

bool within(std::string_view inner, std::string_view outer, SetEffort* effort) {
  return inner == outer ||
         contained({&inner, 1}, {&outer, 1}, limits_with(effort)).kind == SetAnswer::Kind::yes;
}

std::string_view beginning(std::string_view expression) {
  return expression.substr(0, expression.find_first_of("*?[\\"));
}

// True if one name can match both. If that cannot be determined, the two count as overlapping.
bool may_overlap(std::string_view a, std::string_view b, SetEffort* effort) {
  const auto one = beginning(a), other = beginning(b);
  const auto common = std::min(one.size(), other.size());
  if (one.substr(0, common) != other.substr(0, common)) return false;
  auto steps = kLimits.steps;
  if (one.size() == a.size()) return Pattern(b).matches(a, steps).value_or(true);
  if (other.size() == b.size()) return Pattern(a).matches(b, steps).value_or(true);
  return overlap({&a, 1}, {&b, 1}, limits_with(effort)).kind != SetAnswer::Kind::no;
}

std::string_view expression_of(const RuleList& list, Rule rule) {
  if (!rule) return "*";
  // Rules are ascending, but some numbers may be missing.
  const auto item = std::ranges::lower_bound(list.items, *rule, {}, &RuleList::Item::rule);
  return item->expression;
}

// Puts pairs into words one after the other.
class Narrator {
 public:
  Narrator(const RuleList& old_list, const RuleList& new_list, SetEffort* effort)
      : old_(old_list), new_(new_list), effort_(effort) {}

  TopicWords words(const TopicPair& pair) const {
    const auto before = expression_of(old_, pair.old_rule);
    const auto after = expression_of(new_, pair.new_rule);
    TopicWords out;
    if (within(after, before, effort_)) {
      out.expression = after;
    } else {
      out.expression = before;
      if (!within(before, after, effort_)) out.also = after;
    }
    add_exceptions(out, old_, pair.old_rule);
    add_exceptions(out, new_, pair.new_rule);
    return out;
  }

 private:
  // Adds the rules that decide before this one as exceptions.
  void add_exceptions(TopicWords& out, const RuleList& list, Rule rule) const {
    std::size_t looked_at = 0;
    for (const auto& item : list.items) {
      if (rule && item.rule >= *rule) return;
      if (++looked_at > kMaxEarlier || out.more_exceptions) break;
      if (item.expression == out.expression || item.expression == out.also) continue;
      if (std::ranges::find(out.except, item.expression) != out.except.end()) continue;
      if (!may_overlap(item.expression, out.expression, effort_)) continue;
      if (!out.also.empty() && !may_overlap(item.expression, out.also, effort_)) continue;
      if (out.except.size() < kMaxExceptions)
        out.except.emplace_back(item.expression);
      else
        out.more_exceptions = true;
    }
    out.more_exceptions = out.more_exceptions || looked_at > kMaxEarlier;
  }

  const RuleList& old_;
  const RuleList& new_;
  SetEffort* effort_;
};

}  // namespace

TopicSet topics_in_words(const RuleList& old_list, const RuleList& new_list,
                         std::span<const TopicPair> pairs, SetEffort* effort,
                         std::size_t max_pairs) {
  TopicSet out;
  const Narrator narrator(old_list, new_list, effort);
  for (const auto& pair : pairs) {
    if (out.words.size() == max_pairs) {
      ++out.others;
      continue;
    }
    auto words = narrator.words(pair);
    if (std::ranges::find(out.words, words) == out.words.end())
      out.words.push_back(std::move(words));
  }
  return out;
}

}  // namespace ddssec::governance
