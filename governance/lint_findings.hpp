// Collects findings up to a limit. For governance/ only.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/finding.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {

inline constexpr auto kCyclone = "cyclonedds";
inline constexpr auto kFastDds = "fastdds";
inline constexpr auto kOpenDds = "opendds";
inline std::vector<std::string> stock_products() { return {kCyclone, kFastDds}; }

/// The findings of one document, and the effort left for further checks.
class LintFindings {
 public:
  /// `rule` is that of the finding which reports that checks were skipped, if the effort runs out.
  explicit LintFindings(Rule rule) : if_cut_short_(rule) {}

  /// Returns the effort left for questions about sets of names.
  SetEffort& effort() { return effort_; }

  /// Adds a finding unless its rule has kMaxFindingsPerRule.
  void add(Finding finding);
  /// Adds a note of a reader, as a finding of the rule.
  void add(Rule rule, const Note& note, std::vector<std::string> products);
  /// Adds GOV012 or PERM013 if the expression is not portable.
  void add_if_unportable(Rule rule, const Text& expression, const std::string& path);
  /// Adds GOV013 or PERM034 if the expression begins like a name of ROS.
  void add_if_ros_name(Rule rule, const Text& expression, const std::string& path);

  /// Adds a finding if the name contains characters that a terminal hides or reorders.
  void add_if_misleading(Rule rule, std::string_view what, const Text& name,
                         const std::string& path);

  /// Moves out all findings, by line. If some of a rule were left out, its last finding says so.
  std::vector<Finding> take();

 private:
  /// The effort of about a second.
  static constexpr SetEffort kEffort{100'000'000};

  void add_if_cut_short();

  Rule if_cut_short_;
  SetEffort effort_ = kEffort;
  std::vector<Finding> all_;
  std::map<Rule, std::size_t> count_;
};

/// Returns the limits for a question about two expressions, of which a document has many.
SetLimits limits_of_pair(SetEffort& effort);

/// Returns a text such as `no name matches "[z-a]"`.
std::string matches_nothing(std::string_view expression);
inline constexpr std::string_view kUnmatchableHint =
    "write what the expression is meant to match, or delete it";

/// Returns a text such as `"rt/a"`, cut if it is long.
std::string in_quotes(std::string_view text);
/// Returns the RFC 2253 text of a name; with `reverse` it begins with the root.
std::string rfc2253(const pki::SubjectName& name, bool reverse);
/// Returns "3" or "0-5", several with commas.
std::string to_text(const std::vector<DomainRange>& ranges);

}  // namespace ddssec::governance
