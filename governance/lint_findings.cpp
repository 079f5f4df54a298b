#include "governance/lint_findings.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/stable_sort.hpp"
#include "base/text.hpp"
#include "governance/dialect.hpp"
#include "governance/lint.hpp"

namespace ddssec::governance {
namespace {

bool is_special(char c) { return std::string_view(",+\"\\<>;").find(c) != std::string_view::npos; }

}  // namespace

std::string to_sentence(std::string_view expression, const UnportableExpression& found) {
  auto out = fmt::format("{}: {}", in_quotes(expression), found.reason);
  const auto tell = [&](std::string_view product,
                        const std::optional<ReadingDifference>& difference) {
    if (!difference) return;
    out +=
        fmt::format("; {} {} {}, which ddssec {}", product,
                    difference->product_matches ? "matches" : "does not match",
                    in_quotes(difference->name), difference->product_matches ? "does not" : "does");
  };
  tell("Cyclone DDS", found.cyclonedds);
  tell("Fast DDS", found.fastdds);
  return out;
}

void LintFindings::add(Finding finding) {
  if (++count_[finding.rule] <= kMaxFindingsPerRule) all_.push_back(std::move(finding));
}

void LintFindings::add(Rule rule, const Note& note, std::vector<std::string> products) {
  add({.rule = rule,
       .message = note.text,
       .line = note.line,
       .path = note.path,
       .products = std::move(products)});
  count_[rule] += note.more;
}

void LintFindings::add_if_unportable(Rule rule, const Text& expression, const std::string& path) {
  const auto found = unportable(expression.text, effort_);
  if (!found) return;
  Finding finding{.rule = rule,
                  .message = to_sentence(expression.text, *found),
                  .line = expression.line,
                  .path = path};
  if (found->cyclonedds) finding.products.push_back(kCyclone);
  if (found->fastdds) finding.products.push_back(kFastDds);
  if (finding.products.empty()) finding.severity = Severity::informational;
  add(std::move(finding));
}

void LintFindings::add_if_ros_name(Rule rule, const Text& expression, const std::string& path) {
  if (!expression.text.starts_with('/')) return;
  add({.rule = rule,
       .message = fmt::format("{} begins with a slash, as names of ROS do and DDS topics do not",
                              in_quotes(expression.text)),
       .line = expression.line,
       .path = path});
}

void LintFindings::add_if_misleading(Rule rule, std::string_view what, const Text& name,
                                     const std::string& path) {
  const auto found = first_misleading(name.text);
  if (!found) return;
  const auto character = *found == 0xfffd ? std::string("octets that are not UTF-8")
                                          : fmt::format("U+{:04X}", std::uint32_t{*found});
  add({.rule = rule,
       .message = fmt::format("{} {} holds {}", what, in_quotes(name.text), character),
       .line = name.line,
       .path = path});
}

void LintFindings::add_if_cut_short() {
  if (effort_.steps > 0 && effort_.plain_steps > 0) return;
  all_.push_back(
      {.rule = if_cut_short_,
       .message =
           "the expressions take too long to compare: some rules that can never apply, and some "
           "that products read differently, may not be listed",
       .hint = "write fewer \"*\" and \"?\" in one expression, or fewer rules",
       .severity = Severity::warning});
}

std::vector<Finding> LintFindings::take() {
  for (const auto& [rule, count] : count_) {
    if (count <= kMaxFindingsPerRule) continue;
    const auto last = std::find_if(all_.rbegin(), all_.rend(),
                                   [rule](const Finding& f) { return f.rule == rule; });
    last->message += fmt::format(" (and {} more like this)", count - kMaxFindingsPerRule);
  }
  count_.clear();
  add_if_cut_short();
  stable_sort_by(all_, &Finding::line);
  return std::move(all_);
}

SetLimits limits_of_pair(SetEffort& effort) {
  return {.states = 2'000, .steps = 1'000'000, .shared = &effort};
}

std::string matches_nothing(std::string_view expression) {
  return "no name matches " + in_quotes(expression);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kMax = 80;
  return fmt::format("\"{}{}\"", text.substr(0, kMax), text.size() > kMax ? "..." : "");
}

std::string rfc2253(const pki::SubjectName& name, bool reverse) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < name.attributes().size(); ++i) {
    const auto& [type, value] = name.attributes()[i];
    std::string part = type + "=";
    for (std::size_t at = 0; at < value.size(); ++at) {
      const bool is_edge_blank = value[at] == ' ' && (at == 0 || at + 1 == value.size());
      if (is_special(value[at]) || is_edge_blank || (at == 0 && value[at] == '#')) part += '\\';
      part += value[at];
    }
    if (name.is_joined(i) && !parts.empty())
      parts.back() += "+" + part;
    else
      parts.push_back(std::move(part));
  }
  if (reverse) std::ranges::reverse(parts);
  return fmt::format("{}", fmt::join(parts, ","));
}

std::string to_text(const std::vector<DomainRange>& ranges) {
  std::string out;
  for (const auto& range : ranges) {
    if (!out.empty()) out += ", ";
    out += range.first == range.last ? std::to_string(range.first)
                                     : fmt::format("{}-{}", range.first, range.last);
  }
  return out;
}

bool has_errors(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings,
                             [](const Finding& f) { return f.severity >= Severity::error; });
}

}  // namespace ddssec::governance
