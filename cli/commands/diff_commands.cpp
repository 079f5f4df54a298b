// governance diff, permissions diff: report the effect of a change of a document.
#include <algorithm>

#include "cli/commands/groups.hpp"
#include "cli/diff/diff_inputs.hpp"
#include "cli/diff/governance_diff_report.hpp"
#include "cli/diff/permissions_diff_report.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "governance/read.hpp"

namespace ddssec::cli {
namespace {

using governance::ChangeClass;

bool is_worse(ChangeClass verdict, ChangeClass direction) {
  return verdict == direction || verdict == ChangeClass::mixed || verdict == ChangeClass::unknown;
}

bool is_not_only_spelling(const governance::PermissionChange& change) {
  return change.element != "rewritten";
}

bool is_other_to_products(const governance::Interpretations& interpretations,
                          const DiffSides& sides) {
  return !interpretations.all.empty() || sides.before.signer != sides.after.signer;
}

bool is_wider_to_others(const governance::Interpretations& interpretations) {
  return std::ranges::any_of(interpretations.all, [](const governance::Interpretation& reading) {
    return reading.is_new && reading.widens;
  });
}

bool is_narrower_to_others(const governance::Interpretations& interpretations) {
  return std::ranges::any_of(interpretations.all, &governance::Interpretation::narrows);
}

// Warns if stock products read a range of domains differently, because the comparison then does not
// apply to them.
void warn_of_open_ranges(Report& report, Rule rule, const std::vector<governance::Note>& notes,
                         const std::filesystem::path& file) {
  for (const auto& note : notes) {
    if (!governance::is_open_range(note.kind)) continue;
    Finding finding{.rule = rule,
                    .message = note.text,
                    .document = file,
                    .line = note.line,
                    .path = note.path,
                    .products = {"cyclonedds", "fastdds"}};
    report.findings.push_back(std::move(finding));
  }
}

Result<Answer<GovernanceComparison>> governance_diff(const Arguments& arguments,
                                                     const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto threshold, fail_on(arguments, {"weaker", "breaking", "any"}));
  governance::GovernanceDiffOptions options;
  if (arguments.has("--topics")) {
    DDSSEC_ASSIGN_OR_RETURN(options.topics, read_topics(arguments.text("--topics")));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto sides,
                          diff_sides(document_path<GovernanceKind>, arguments, context));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto before,
      with_default_document(governance::read_governance(sides.before.text, sides.before.first_line),
                            sides.before.path));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto after,
      with_default_document(governance::read_governance(sides.after.text, sides.after.first_line),
                            sides.after.path));
  auto diff = governance::compare(before, after, options);
  auto live = forecast_of(before, after, sides, diff.changes.empty() && diff.rewritten.empty());
  Report report;
  warn_of_open_ranges(report, Rule::GOV004, before.notes, sides.before.path);
  warn_of_open_ranges(report, Rule::GOV004, after.notes, sides.after.path);
  const bool unknown = diff.verdict == ChangeClass::unknown;
  const bool reached = threshold == "weaker" ? is_worse(diff.verdict, ChangeClass::weaker) ||
                                                   is_wider_to_others(diff.interpretations)
                       : threshold == "breaking" ? unknown || !diff.flag_day_domains.empty()
                       : threshold == "any"      ? unknown || !diff.changes.empty() ||
                                                  is_other_to_products(diff.interpretations, sides)
                                            : false;
  if (is_wider_to_others(diff.interpretations))
    report.text += "this verdict is ddssec's; another product allows more, as is listed above\n";
  if (reached) report.exit = Exit::no;
  return Answer<GovernanceComparison>{
      {std::move(diff), sides, std::move(live), arguments.has("--topics")}, std::move(report)};
}

Result<Answer<PermissionsComparison>> permissions_diff(const Arguments& arguments,
                                                       const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto threshold, fail_on(arguments, {"wider", "narrower", "any"}));
  DDSSEC_ASSIGN_OR_RETURN(const auto sides,
                          diff_sides(document_path<PermissionsKind>, arguments, context));
  DDSSEC_ASSIGN_OR_RETURN(const auto before,
                          with_default_document(governance::read_permissions(
                                                    sides.before.text, sides.before.first_line),
                                                sides.before.path));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto after,
      with_default_document(governance::read_permissions(sides.after.text, sides.after.first_line),
                            sides.after.path));
  auto diff = governance::compare(before, after,
                                  {.map_subjects_by_grant_name = arguments.has("--subject-map")});
  auto forecast = forecast_of({before, after, diff, context.clock.calendar_seconds()}, sides);
  Report report;
  warn_of_open_ranges(report, Rule::PERM004, before.notes, sides.before.path);
  warn_of_open_ranges(report, Rule::PERM004, after.notes, sides.after.path);
  const bool reached =
      threshold == "wider"
          ? is_worse(diff.verdict, ChangeClass::wider) || is_wider_to_others(diff.interpretations)
      : threshold == "narrower" ? is_worse(diff.verdict, ChangeClass::narrower) ||
                                      is_narrower_to_others(diff.interpretations)
      : threshold == "any" ? std::ranges::any_of(diff.changes, is_not_only_spelling) ||
                                 is_other_to_products(diff.interpretations, sides)
                           : false;
  if (is_wider_to_others(diff.interpretations))
    report.text += "this verdict is ddssec's; another product allows more, as is listed above\n";
  if (reached) report.exit = Exit::no;
  return Answer<PermissionsComparison>{{std::move(diff), sides, std::move(forecast)},
                                       std::move(report)};
}

const Positional kOld{"OLD", "the document as it was, XML or signed, or a participant's folder"};
const Positional kNew{"NEW", "the document as it will be"};
constexpr Option kCa{"--ca", "CERT", "verify signed documents against this permissions CA"};

}  // namespace

std::vector<Command> diff_commands() {
  return {
      {.group = "governance",
       .name = "diff",
       .summary = "Compares two governance documents by what they do, topic by topic.",
       .positionals = {kOld, kNew},
       .options = {{"--fail-on", "WHAT", "exit 1 for weaker, breaking or any differences"},
                   {"--topics", "FILE", "compare for these topics only, one a line"},
                   kCa},
       .examples = {"ddssec governance diff old.p7s new.xml --fail-on weaker"},
       .run = governance_diff},
      {.group = "permissions",
       .name = "diff",
       .summary = "Compares two permissions documents as sets of what they allow.",
       .positionals = {kOld, kNew},
       .options = {{"--fail-on", "WHAT", "exit 1 for wider, narrower or any differences"},
                   {"--subject-map", "",
                    "subjects that came and went are the same if their grants have the same name"},
                   kCa},
       .examples = {"ddssec permissions diff talker/permissions.p7s new.xml --fail-on wider"},
       .run = permissions_diff}};
}

}  // namespace ddssec::cli
