#include "governance/compare/permissions_diff.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "base/stable_sort.hpp"
#include "governance/compare/comparison_effort.hpp"
#include "governance/compare/stock_changes.hpp"
#include "governance/compare/subjects.hpp"
#include "governance/cyclonedds_subject.hpp"
#include "governance/grant.hpp"
#include "governance/product_reading.hpp"

namespace ddssec::governance {
namespace {

// The grants that apply at the same times.
struct GrantPairs {
  std::set<std::pair<const Grant*, const Grant*>> both;
  Grants only_old, only_new;  // valid while the other document has no valid grant
  std::set<const Grant*> used;
};

GrantPairs pairs_of(const Subject& subject) {
  std::set<WallTime> cuts;
  for (const auto& grants : {subject.old_grants, subject.new_grants}) {
    for (const Grant* grant : grants) {
      cuts.insert(grant->validity.not_before);
      cuts.insert(grant->validity.not_after);
    }
  }
  GrantPairs pairs;
  for (const auto time : cuts) {
    const auto* o = valid_at(subject.old_grants, time);
    const auto* n = valid_at(subject.new_grants, time);
    pairs.used.insert({o, n});
    if (o && n) pairs.both.emplace(o, n);
    if (o && !n) pairs.only_old.push_back(o);
    if (n && !o) pairs.only_new.push_back(n);
  }
  return pairs;
}

// Every expression of the grant's rules.
std::set<std::string> expressions_of(const Grant& grant) {
  std::set<std::string> out;
  const auto add = [&](const std::vector<Text>& texts) {
    for (const auto& text : texts) out.insert(text.text);
  };
  for (const auto& rule : grant.rules) {
    add(rule.domains.tag_expressions);
    for (const auto* list : {&rule.publish, &rule.subscribe, &rule.relay})
      for (const auto& criteria : *list) {
        add(criteria.topics);
        if (criteria.partitions) add(*criteria.partitions);
      }
  }
  return out;
}

std::vector<std::string> missing(const std::set<std::string>& from,
                                 const std::set<std::string>& in) {
  std::vector<std::string> out;
  std::ranges::set_difference(from, in, std::back_inserter(out));
  return out;
}

// A fraction of a second makes a validity shorter, so that ends which look alike may be a second
// apart.
std::string hint_on(const Validity& o, const Validity& n) {
  const auto is_close = [](WallTime a, WallTime b) {
    return a != b && std::chrono::abs(a - b) <= std::chrono::seconds(1);
  };
  if (is_close(o.not_before, n.not_before) || is_close(o.not_after, n.not_after))
    return "they are one second apart: ddssec counts whole seconds, and a fraction of one makes a "
           "validity shorter";
  return {};
}

std::string period(const Grant& grant) {
  return ddssec::to_string(grant.validity.not_before) + " .. " +
         ddssec::to_string(grant.validity.not_after);
}

bool are_plain(const Grants& grants) {
  return std::ranges::none_of(grants, &Grant::subject_is_expression);
}

class PermissionsComparison {
 public:
  PermissionsComparison(const Permissions& old_document, const Permissions& new_document,
                        const PermissionsDiffOptions& options)
      : options_(options),
        limits_(options.limits.sharing(effort_)),
        subjects_(subjects_of(old_document, new_document)) {
    diff_.interpretations = interpretations_of(old_document, new_document);
  }

  PermissionsDiff run() {
    if (!subjects_.is_exact) {
      diff_.is_exact = false;
      direction_.add(ChangeClass::unknown);
    }
    if (options_.map_subjects_by_grant_name) map_subjects();
    for (const auto& subject : subjects_.all) compare_subject(subject);
    diff_.verdict = direction_.change_class(ChangeClass::narrower, ChangeClass::wider);
    stable_sort_descending_by(diff_.changes, [](const PermissionChange& change) {
      return std::pair(change.element == "default", change.change);
    });
    return std::move(diff_);
  }

 private:
  void map_subjects();
  void compare_subject(const Subject& subject);
  void compare_presence(const Grant& grant, const Grants& valid, bool is_new);
  void compare_rules(const Grant& o, const Grant& n);
  GrantDiff rules_of(const Grant& o, const Grant& n) const {
    return compare_grants(o, n, limits_, options_.first_rule_creates_topic);
  }
  void compare_spelling(const Grant& o, const Grant& n);
  void compare_times(const Subject& subject, const GrantPairs& pairs);
  void note_dead(const Subject& subject, const GrantPairs& pairs);
  void add_rules(const GrantDiff& rules);
  void add(PermissionChange change);

  const PermissionsDiffOptions& options_;
  SetEffort effort_ = kEffortOfComparison;
  SetLimits limits_;
  Subjects subjects_;
  PermissionsDiff diff_;
  CombinedChange direction_;
  std::string shown_subject_;
};

void PermissionsComparison::add(PermissionChange change) {
  change.subject = shown_subject_;
  direction_.add(change.change);
  diff_.changes.push_back(std::move(change));
}

void PermissionsComparison::map_subjects() {
  auto& all = subjects_.all;
  std::map<std::string_view, std::vector<std::size_t>> old_names, new_names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].new_grants.empty()) old_names[all[i].old_grants[0]->name].push_back(i);
    if (all[i].old_grants.empty()) new_names[all[i].new_grants[0]->name].push_back(i);
  }
  std::set<std::size_t> moved;
  for (const auto& [name, from] : old_names) {
    const auto to = new_names.find(name);
    // A name that several grants have identifies none of them.
    if (name.empty() || to == new_names.end() || from.size() != 1 || to->second.size() != 1)
      continue;
    // An expression is for many subjects, whatever the grant's name is: no participant was renamed.
    if (!are_plain(all[from[0]].old_grants) || !are_plain(all[to->second[0]].new_grants)) continue;
    all[from[0]].new_grants = std::move(all[to->second[0]].new_grants);
    moved.insert(to->second[0]);
  }
  std::vector<Subject> left;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!moved.contains(i)) left.push_back(std::move(all[i]));
  }
  all = std::move(left);
}

void PermissionsComparison::compare_subject(const Subject& subject) {
  const auto& [old_grants, new_grants] = subject;
  shown_subject_ = spelling_of(subject).subject_name;
  const auto pairs = pairs_of(subject);
  if (old_grants.empty()) return compare_presence(*new_grants[0], pairs.only_new, true);
  if (new_grants.empty()) return compare_presence(*old_grants[0], pairs.only_old, false);
  const bool is_renewal = pairs.both.empty() && !pairs.only_old.empty() && !pairs.only_new.empty();
  for (const auto& [o, n] : pairs.both) compare_spelling(*o, *n);
  if (is_renewal) compare_spelling(*pairs.only_old[0], *pairs.only_new[0]);
  compare_times(subject, pairs);
  note_dead(subject, pairs);
  for (const auto& [o, n] : pairs.both) compare_rules(*o, *n);
  if (!is_renewal) return;
  // A renewal moves both ends of the validity, so by its times alone it would count as narrower and
  // wider. Only the rules decide.
  auto rules = rules_of(*pairs.only_old[0], *pairs.only_new[0]);
  rules.direction = {};
  add_rules(rules);
}

void PermissionsComparison::compare_rules(const Grant& o, const Grant& n) {
  const auto rules = rules_of(o, n);
  add_rules(rules);
  if (!rules.changes.empty() || !rules.is_exact) return;
  const auto before = expressions_of(o), after = expressions_of(n);
  if (before == after) return;
  add({.element = "rewritten",
       .change = ChangeClass::neutral,
       .expressions_old = missing(before, after),
       .expressions_new = missing(after, before),
       .old_line = o.line,
       .new_line = n.line});
}

void PermissionsComparison::compare_presence(const Grant& grant, const Grants& valid, bool is_new) {
  static const Grant kNothing;
  PermissionChange change{.element = "grant"};
  // A grant that is never valid has no effect.
  if (!valid.empty()) change.change = is_new ? ChangeClass::wider : ChangeClass::narrower;
  change.old_value = is_new ? "absent" : "present";
  change.new_value = is_new ? "present" : "absent";
  (is_new ? change.new_line : change.old_line) = grant.line;
  add(std::move(change));
  const std::set<const Grant*> each(valid.begin(), valid.end());
  for (const Grant* allowed : each)
    add_rules(is_new ? rules_of(kNothing, *allowed) : rules_of(*allowed, kNothing));
}

void PermissionsComparison::compare_spelling(const Grant& o, const Grant& n) {
  if (o.subject_name == n.subject_name && o.subject_is_expression == n.subject_is_expression)
    return;
  const bool is_same = same_subjects(o, n);
  if (!options_.map_subjects_by_grant_name && !is_same) return;
  const auto text = [](const Grant& grant) {
    return (grant.subject_is_expression ? "expression " : "") + grant.subject_name;
  };
  add({.element = "subject_name",
       .change = is_same ? ChangeClass::interop : ChangeClass::neutral,
       .old_value = text(o),
       .new_value = text(n),
       .old_line = o.line,
       .new_line = n.line,
       .hint =
           is_same ? "" : "another subject, taken for the same participant by its grant's name"});
}

void PermissionsComparison::compare_times(const Subject& subject, const GrantPairs& pairs) {
  const Grant &o = *subject.old_grants[0], &n = *subject.new_grants[0];
  CombinedChange direction;
  if (!pairs.only_old.empty()) direction.add(ChangeClass::narrower);
  if (!pairs.only_new.empty()) direction.add(ChangeClass::wider);
  if (!direction.up() && !direction.down()) return;
  add({.element = "validity",
       .change = direction.change_class(ChangeClass::narrower, ChangeClass::wider),
       .old_value = period(o),
       .new_value = period(n),
       .old_line = o.line,
       .new_line = n.line,
       .hint = hint_on(o.validity, n.validity)});
}

void PermissionsComparison::note_dead(const Subject& subject, const GrantPairs& pairs) {
  const auto dead = [&](const Grants& grants) {
    return std::ranges::count_if(grants, [&](const Grant* g) { return !pairs.used.contains(g); });
  };
  const auto before = dead(subject.old_grants), after = dead(subject.new_grants);
  if (before == after) return;
  const auto& grants = before < after ? subject.new_grants : subject.old_grants;
  const auto* grant =
      *std::ranges::find_if(grants, [&](const Grant* g) { return !pairs.used.contains(g); });
  const auto count = [](auto number) { return std::to_string(number) + " without effect"; };
  add({.element = "grant",
       .change = ChangeClass::neutral,
       .old_value = count(before),
       .new_value = count(after),
       .old_line = before < after ? 0 : grant->line,
       .new_line = before < after ? grant->line : 0});
}

void PermissionsComparison::add_rules(const GrantDiff& rules) {
  direction_.add(rules.direction);
  diff_.is_complete = diff_.is_complete && rules.is_complete;
  diff_.is_exact = diff_.is_exact && rules.is_exact;
  for (const auto& change : rules.changes) {
    diff_.changes.push_back(change);
    diff_.changes.back().subject = shown_subject_;
  }
}

// True if there is a deny_rule about topics: Cyclone DDS may then refuse to create these topics.
bool denies_topics(const Permissions& document) {
  return std::ranges::any_of(document.grants, [](const Grant& grant) {
    return std::ranges::any_of(grant.rules, [](const GrantRule& rule) {
      return !rule.allow && (!rule.publish.empty() || !rule.subscribe.empty());
    });
  });
}

// Adds the comparisons of the documents as Cyclone DDS applies them. `differs_from_written` is true
// if Cyclone DDS reads something in them differently from what is written.
void add_cyclonedds(std::vector<StockPermissionsDiff>& stock, const Permissions& o,
                    const Permissions& n, bool differs_from_written,
                    PermissionsDiffOptions options) {
  constexpr auto kProduct = StockProduct::cyclonedds;
  options.first_rule_creates_topic = denies_topics(o) || denies_topics(n);
  const auto taken = applied_by_cyclonedds(o, n);
  for (const auto& pair : taken)
    stock.push_back({kProduct, PermissionsComparison(pair.before, pair.after, options).run()});
  if (taken.empty() && (differs_from_written || options.first_rule_creates_topic))
    stock.push_back({kProduct, PermissionsComparison(o, n, options).run()});
}

}  // namespace

PermissionsDiff compare(const Permissions& old_document, const Permissions& new_document,
                        const PermissionsDiffOptions& options) {
  auto out = PermissionsComparison(old_document, new_document, options).run();
  std::vector<StockPermissionsDiff> stock;
  for (const auto product : kStockProducts) {
    const auto before = rewritten_for(old_document, product);
    const auto after = rewritten_for(new_document, product);
    const auto& o = before ? *before : old_document;
    const auto& n = after ? *after : new_document;
    if (product == StockProduct::cyclonedds)
      add_cyclonedds(stock, o, n, before || after, options);
    else if (before || after)
      stock.push_back({product, PermissionsComparison(o, n, options).run()});
  }
  if (const auto own = rewritten_for_own_endpoints_of_fastdds(old_document, new_document))
    stock.push_back({.product = StockProduct::fastdds,
                     .diff = PermissionsComparison(own->before, own->after, options).run(),
                     .is_of_own_endpoints = true});
  add_stock_changes(stock, out);
  return out;
}

}  // namespace ddssec::governance
