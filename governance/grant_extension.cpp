#include "governance/grant_extension.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include "governance/decision.hpp"
#include "governance/write.hpp"

namespace ddssec::governance {
namespace {

bool have_same_rules(const Criteria& a, const Criteria& b) {
  return a.topics == b.topics && a.partitions == b.partitions && a.data_tags == b.data_tags;
}

bool have_same_rules(const GrantRule& a, const GrantRule& b) {
  const auto equal = [](const auto& of_a, const auto& of_b) {
    return std::ranges::equal(of_a, of_b,
                              [](const auto& x, const auto& y) { return have_same_rules(x, y); });
  };
  return a.allow == b.allow && equal(a.publish, b.publish) && equal(a.subscribe, b.subscribe) &&
         equal(a.relay, b.relay);
}

std::string_view key(const Text& text) { return text.text; }
const DataTag& key(const DataTag& tag) { return tag; }

// The longest lists that are compared element by element, because a participant compares again and
// again. Longer lists must be the same.
constexpr std::size_t kMaxListed = 1024;
constexpr std::size_t kMaxCriteria = 16;

template <class One>
bool has_all(const std::vector<One>& wide, const std::vector<One>& narrow) {
  if (wide == narrow) return true;
  if (wide.size() > kMaxListed || narrow.size() > kMaxListed) return false;
  const auto sorted = [](const std::vector<One>& list) {
    std::vector<std::decay_t<decltype(key(list.front()))>> out;
    for (const auto& one : list) out.push_back(key(one));
    std::ranges::sort(out);
    return out;
  };
  return std::ranges::includes(sorted(wide), sorted(narrow));
}

// The rules that are compared: two allow rules, or two deny rules.
enum class RuleKind : std::uint8_t { allow, deny };

// True if `wide` has everything that `narrow` has. In a deny rule an absent list matches
// everything; in an allow rule it matches nothing that a list names.
template <class One>
bool has_all(const std::optional<std::vector<One>>& wide,
             const std::optional<std::vector<One>>& narrow, RuleKind kind) {
  if (!wide && kind == RuleKind::deny) return true;
  if (!wide || !narrow) return wide.has_value() == narrow.has_value();
  return has_all(*wide, *narrow);
}

bool covers(const Criteria& wide, const Criteria& narrow, RuleKind kind) {
  return has_all(wide.topics, narrow.topics) && has_all(wide.partitions, narrow.partitions, kind) &&
         has_all(wide.data_tags, narrow.data_tags, kind);
}

// True if each of `narrow` is covered by one of `wide`.
bool covers(const std::vector<Criteria>& wide, const std::vector<Criteria>& narrow, RuleKind kind) {
  if (wide.size() > kMaxCriteria || narrow.size() > kMaxCriteria)
    return std::ranges::equal(wide, narrow,
                              [](const auto& a, const auto& b) { return have_same_rules(a, b); });
  return std::ranges::all_of(narrow, [&](const Criteria& one) {
    return std::ranges::any_of(wide,
                               [&](const Criteria& other) { return covers(other, one, kind); });
  });
}

// True if `wide` matches everything that `narrow` matches.
bool matches_all_of(const GrantRule& wide, const GrantRule& narrow, RuleKind kind) {
  return covers(wide.publish, narrow.publish, kind) &&
         covers(wide.subscribe, narrow.subscribe, kind) && covers(wide.relay, narrow.relay, kind);
}

// True if `next` may take the place of `former`.
bool fits(const GrantRule& next, const GrantRule& former) {
  if (next.allow != former.allow) return false;
  if (next.allow) return matches_all_of(next, former, RuleKind::allow);
  return matches_all_of(former, next, RuleKind::deny) &&
         (decides_joining(former) || !decides_joining(next));
}

std::string rights_in(Grant grant) {
  grant.name = grant.subject_name = "X";
  grant.subject_is_expression = grant.subject_has_line_breaks = false;
  grant.validity = {};
  return to_xml(Permissions{.grants = {std::move(grant)}});
}

std::vector<const GrantRule*> rules_of(const Grant& grant) {
  std::vector<const GrantRule*> out;
  for (const auto& rule : grant.rules) out.push_back(&rule);
  return out;
}

}  // namespace

std::vector<const GrantRule*> rules_for(const Grant& grant, DomainId domain, std::string_view tag) {
  std::vector<const GrantRule*> out;
  for (const auto& rule : grant.rules)
    if (rule.domains.contains(domain, tag)) out.push_back(&rule);
  return out;
}

bool have_same_rules(std::span<const GrantRule* const> a, std::span<const GrantRule* const> b) {
  return std::ranges::equal(a, b,
                            [](const auto* x, const auto* y) { return have_same_rules(*x, *y); });
}

// The first rule that matches decides. If a rule of `former` allows an entity, its counterpart in
// `next` matches the entity too. Before the counterpart, `next` has only further allow rules and
// counterparts of earlier rules of `former`. No deny rule among these matches, because its original
// in `former` did not match.
bool gives_at_least(const Decisions& next, const Decisions& former) {
  auto at = next.rules.begin();
  auto old = former.rules.begin();
  while (at != next.rules.end() || old != former.rules.end()) {
    const bool are_both = at != next.rules.end() && old != former.rules.end();
    if (are_both && fits(**at, **old)) {
      ++at;
      ++old;
    } else if (old != former.rules.end() && !(*old)->allow) {
      ++old;
    } else if (at != next.rules.end() && (*at)->allow) {
      ++at;
    } else {
      return false;
    }
  }
  return next.default_allow || !former.default_allow;
}

bool give_same_rights(const Grant& a, const Grant& b) {
  return a.subject_name == b.subject_name && rights_in(a) == rights_in(b);
}

bool gives_at_least(const Grant& next, const Grant& former) {
  if (give_same_rights(next, former)) return true;
  if (next.subject_name != former.subject_name || former.rules.empty()) return false;
  const auto& domains = former.rules.front().domains;
  const auto are_alike = [&](const Grant& grant) {
    return std::ranges::all_of(grant.rules,
                               [&](const auto& rule) { return rule.domains == domains; });
  };
  if (!are_alike(next) || !are_alike(former)) return false;
  const auto next_rules = rules_of(next), former_rules = rules_of(former);
  return gives_at_least(Decisions{next_rules, next.default_allow},
                        Decisions{former_rules, former.default_allow});
}

}  // namespace ddssec::governance
