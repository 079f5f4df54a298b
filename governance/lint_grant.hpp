// One grant for lint, and its rules as a list of expressions. For governance/ only.
#pragma once

#include <array>
#include <set>
#include <string>
#include <vector>

#include "governance/lint.hpp"
#include "governance/lint_findings.hpp"

namespace ddssec::governance {

/// One topic expression of a rule.
struct GrantEntry {
  const GrantRule* rule;
  std::size_t rule_number;  ///< number among all rules of the grant, from 1
  const Criteria* criteria;
  const Text* topic;
};

/// A grant and its place in the document.
class GrantPlace {
 public:
  GrantPlace(const Grant& grant, std::size_t number);

  const Grant& grant() const { return grant_; }
  const std::string& path() const { return path_; }
  const std::string& rule_path(std::size_t rule_number) const {
    return rule_paths_.at(rule_number - 1);
  }
  /// Returns every expression of all publish elements, in document order.
  const std::vector<GrantEntry>& publish() const { return entries_[0]; }
  const std::vector<GrantEntry>& subscribe() const { return entries_[1]; }
  const std::array<std::vector<GrantEntry>, 2>& actions() const { return entries_; }

  Finding about(Rule id, std::string message) const;
  Finding about(Rule id, const GrantEntry& entry, std::string message) const;
  Finding about_rule(Rule id, std::size_t rule_number, std::string message) const;

 private:
  const Grant& grant_;
  std::string path_;
  std::vector<std::string> rule_paths_;
  std::array<std::vector<GrantEntry>, 2> entries_;
};

/// "publish", "subscribe": the names of GrantPlace::actions().
inline constexpr std::array<std::string_view, 2> kActionNames = {"publish", "subscribe"};

/// Returns a text such as "allow_rule 2".
std::string rule_name(const GrantEntry& entry);

/// Returns the partitions that the element lists; none if it lists none.
const std::vector<Text>& listed_partitions(const Criteria& criteria);

/// Returns the texts of the entries that are in an allow_rule.
std::vector<std::string_view> allowed_texts(const std::vector<GrantEntry>& entries);

/// Returns the partitions to which an allow rule's element applies.
std::vector<std::string_view> allowed_partitions(const Criteria& criteria);
/// Returns the partitions to which a denial applies: without a list, all.
std::vector<std::string_view> denied_partitions(const GrantEntry& denial);
/// True if `earlier` allows, and `denial` denies, in a common domain and partition. Their topics
/// are not compared.
bool allows_before(const GrantEntry& earlier, const GrantEntry& denial, SetEffort& effort);

/// Checks PERM012: rules that can never apply. Returns the topics of the entries that it reports.
std::set<const Text*> lint_dead_rules(LintFindings& out, const GrantPlace& place);
/// Checks PERM016, except for the entries in `reported`.
void lint_overlaps(LintFindings& out, const GrantPlace& place,
                   const std::set<const Text*>& reported);
/// Checks PERM012: partitions, tags, relayed topics and subjects that no name matches.
void lint_unmatchable(LintFindings& out, const GrantPlace& place);
/// Checks PERM013 to PERM015, PERM020 to PERM027, PERM034.
void lint_rights(LintFindings& out, const GrantPlace& place, const Governance* governance);
/// Checks PERM030, PERM032, PERM033, if the grant concerns ROS 2.
void lint_ros(LintFindings& out, const GrantPlace& place);

}  // namespace ddssec::governance
