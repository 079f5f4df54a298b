#include "cli/diff/permissions_diff_report.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/diff/diff_words.hpp"

namespace ddssec::cli {
namespace {

using governance::ChangeClass;
using governance::PermissionChange;

std::string decided_by(const std::vector<std::string>& expressions) {
  return expressions.empty() ? "the default" : names_text(expressions);
}

// The description of a change, as the parts of a line.
std::vector<std::string> parts_of(const PermissionChange& change) {
  const auto values = fmt::format("{} -> {}", change.old_value, change.new_value);
  if (change.element == "rule" && change.change == ChangeClass::unknown) {
    return {fmt::format("{}: too many combinations of expressions to compare",
                        change.operation.empty() ? "tags" : change.operation)};
  }
  if (change.element == "rule") {
    const auto by = fmt::format("by {} -> by {}", decided_by(change.expressions_old),
                                decided_by(change.expressions_new));
    return {fmt::format("{} {}", change.operation, topics_text(change.topics, change.witness)),
            entities_text(change.entities), values, by};
  }
  if (change.element == "default")
    return {"default " + values, "for all that no rule mentions, in every domain"};
  if (change.element == "join") return {"joining the domain " + values};
  if (change.element == "rewritten") {
    const auto side = [](const std::vector<std::string>& expressions) {
      return expressions.empty() ? std::string("nothing") : names_text(expressions);
    };
    return {"written differently", side(change.expressions_old),
            "-> " + side(change.expressions_new), "no name is treated differently"};
  }
  if (change.element == "validity") {
    return {"validity", change.old_value, "-> " + change.new_value};
  }
  if (change.element == "grant") return {"grant " + values};
  if (change.element == "subject_name") {
    const bool is_same = change.change == ChangeClass::interop;
    return {"subject", name_text(change.old_value), "-> " + name_text(change.new_value),
            is_same ? "(the same to ddssec; other products compare the text)" : ""};
  }
  return {fmt::format("{} {}", change.element, values), "not compared any further"};
}

std::string to_text(const PermissionChange& change) {
  const auto word = governance::to_string(change.change);
  const bool harmless =
      change.change == ChangeClass::neutral || change.change == ChangeClass::interop;
  auto parts = parts_of(change);
  if (change.element != "default" && !change.scope.domains.empty())
    parts.push_back(scope_text(change.scope));
  parts.push_back(lines_text(change.old_line, change.new_line));
  if (!change.hint.empty()) parts.push_back("(" + change.hint + ")");
  return wrapped(fmt::format("  {:<9} ", harmless ? std::string(word) : ascii_upper(word)), parts);
}

std::string verdict_text(const governance::PermissionsDiff& diff) {
  const auto word = ascii_upper(governance::to_string(diff.verdict));
  std::string text;
  if (!diff.is_complete) text += "more rules than are named here changed in the same ways\n";
  if (!diff.is_exact) {
    text += wrapped("", {"UNKNOWN:", "there are too many partitions, data tags or subjects to try",
                         "every combination"});
  }
  const bool is_read_otherwise =
      std::ranges::any_of(diff.interpretations.all,
                          [](const auto& one) { return one.widens || one.narrows; }) ||
      std::ranges::any_of(diff.changes, [](const auto& change) {
        return change.element == "subject_name" && change.change == ChangeClass::interop;
      });
  text += is_read_otherwise
              ? fmt::format(
                    "verdict: {} for ddssec's plugins; the lines \"interop\" say what "
                    "changes with other products\n",
                    word)
              : fmt::format("verdict: {}; old and new files work together\n", word);
  return text;
}

}  // namespace

std::vector<ShownPermissionChange> PermissionsComparison::changes() const {
  std::vector<ShownPermissionChange> out;
  for (const auto& change : diff.changes) out.push_back({&change, &sides});
  return out;
}

std::string PermissionsComparison::text() const {
  // The most serious subject comes first, each with all its changes.
  std::vector<std::string> subjects;
  std::map<std::string_view, std::string> texts;
  for (const auto& change : diff.changes) {
    auto& text = texts[change.subject];
    if (text.empty()) subjects.push_back(change.subject);
    text += to_text(change);
  }
  std::string out;
  for (const auto& subject : subjects)
    out += fmt::format("subject {}\n{}", name_text(subject), texts[subject]);
  return out + interpretations_text(diff.interpretations) + signer_text(sides) +
         verdict_text(diff) + takes_effect.text;
}

}  // namespace ddssec::cli
