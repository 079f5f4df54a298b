// explain: what a code of an error or a rule of lint and doctor means, and what to do about it.
#include <algorithm>

#include <fmt/format.h>

#include "base/finding.hpp"
#include "base/text.hpp"
#include "cli/groups.hpp"

namespace ddssec::cli {
namespace {

/// A row of either table.
struct Row {
  std::string_view name;
  int number;  ///< 0: rules have none
  Severity severity;
  std::string_view summary;
  std::string_view hint;
};

// As messages show it ("error[usage]:"), in any case.
std::string bare(std::string_view given) {
  if (const auto open = given.find('['); open != given.npos)
    given = given.substr(open + 1, given.find(']') - open - 1);
  return ascii_upper(given);
}

std::optional<Row> find(const std::string& wanted) {
  for (const auto& code : all_codes()) {
    const auto number = static_cast<int>(code.code);
    if (ascii_upper(code.name) == wanted || std::to_string(number) == wanted)
      return Row{code.name, number, code.severity, code.summary, code.hint};
  }
  for (const auto& rule : all_rules())
    if (rule.id == wanted) return Row{rule.id, 0, rule.severity, rule.title, rule.hint};
  return std::nullopt;
}

Result<Report> explain(const Arguments& arguments, const Context&) {
  const auto wanted = arguments.text("CODE");
  const auto row = find(bare(wanted));
  if (!row)
    return fail(Code::usage, {.field = "CODE",
                              .expected = "a name or number as messages show it in brackets",
                              .found = '"' + wanted.substr(0, 64) + '"'});
  Report report;
  // A rule's title says what is looked at, not what was found.
  const bool is_rule = row->number == 0;
  report.text = fmt::format("{}{} ({})\n  {}{}\n  {}{}\n", row->name,
                            is_rule ? "" : fmt::format(" {}", row->number),
                            to_string(row->severity), is_rule ? "checks: " : "", row->summary,
                            is_rule ? "if it fails: " : "", row->hint);
  report.result = {{"name", row->name}};
  if (row->number != 0) report.result["number"] = row->number;
  report.result["severity"] = to_string(row->severity);
  report.result["summary"] = row->summary;
  report.result["hint"] = row->hint;
  return report;
}

}  // namespace

std::vector<Command> explain_commands() {
  return {{.group = "",
           .name = "explain",
           .summary = "Says what a code means and what to do about it.",
           .positionals = {{"CODE", "its name or number"}},
           .options = {},
           .examples = {"ddssec explain no_grant_for_subject", "ddssec explain 1242"},
           .run = explain}};
}

}  // namespace ddssec::cli
