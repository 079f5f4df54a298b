// explain: explains an error code, a rule of lint and doctor, a verdict of doctor, or a sentence of
// a log, and what to do about it.
#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <ranges>

#include <fmt/format.h>

#include "base/finding.hpp"
#include "base/text.hpp"
#include "cli/commands/groups.hpp"
#include "cli/explain/explain_examples.hpp"
#include "cli/explain/log_sentences.hpp"
#include "cli/frame/explain_severities.hpp"
#include "cli/frame/suggestions.hpp"
#include "governance/doctor/product.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;

constexpr std::size_t kMinPartLength = 4;  // characters

// A row of the table of codes or of the table of rules.
struct Row {
  std::string_view name;
  int number;  // 0 for a rule
  Severity severity;
  std::string_view summary;
  std::string_view hint;
};

// Returns the name within a message such as "error[usage]:", in upper case.
std::string without_brackets(std::string_view given) {
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

// The code that a line of a log names: "[name 1142]" at its end, as ddssec writes it, or the
// "(code: 1142)" that Cyclone DDS adds to its own. The text before them may quote a peer.
std::optional<Row> find_in_line(std::string_view line) {
  constexpr std::string_view kOfCyclone = "(code: ";
  line = line.substr(0, line.find_last_not_of(" \t\r\n") + 1);
  const auto open = line.rfind('[');
  if (open != line.npos && line.ends_with(']')) {
    const auto text = line.substr(open + 1, line.size() - open - 2);
    const auto row = find(ascii_upper(text.substr(0, text.find(' '))));
    if (row && text == fmt::format("{} {}", row->name, row->number)) return row;
  }
  const auto code = line.rfind(kOfCyclone);
  if (code == line.npos) return std::nullopt;
  const auto number = line.substr(code + kOfCyclone.size());
  return find(std::string(number.substr(0, number.find(')'))));
}

// `names` are separated by blanks.
bool is_among(std::string_view name, std::string_view names) {
  return std::ranges::any_of(std::views::split(names, ' '), [&](const auto& part) {
    return std::string_view(part.begin(), part.end()) == name;
  });
}

std::vector<std::string_view> examples_of(std::string_view name) {
  std::vector<std::string_view> out;
  for (const auto& example : explain_examples())
    if (is_among(name, example.names)) out.push_back(example.line);
  return out;
}

// The severity as logs show it for a code, or as lint and doctor show it for a rule.
std::string_view severity_of(const Row& row) {
  return row.number == 0 ? severity_word(row.severity) : to_string(row.severity);
}

std::vector<OtherSeverity> others_of(const Row& row) {
  std::vector<OtherSeverity> out;
  std::ranges::copy_if(other_severities(), std::back_inserter(out),
                       [&](const auto& other) { return is_among(row.name, other.names); });
  if (row.number == 0) return out;
  const auto in_tool = severity_in_tool(static_cast<Code>(row.number));
  if (in_tool != row.severity)
    out.push_back({row.name, in_tool, "where a command of ddssec reports it"});
  return out;
}

struct SeverityElsewhere {
  std::string severity, when;

  static constexpr auto fields() {
    return std::tuple(field<&SeverityElsewhere::severity>({.def = "severity"}),
                      field<&SeverityElsewhere::when>());
  }
};

// A code or a rule.
struct ExplainedName {
  std::string name;
  std::optional<std::size_t> number;
  std::string severity;
  std::vector<SeverityElsewhere> other_severities = {};
  std::string summary, hint;
  std::vector<std::string> examples = {};

  static constexpr auto fields() {
    return std::tuple(
        field<&ExplainedName::name>(),
        field<&ExplainedName::number>({.note = "rules have none", .omits_empty = true}),
        field<&ExplainedName::severity>({.def = "severity"}),
        field<&ExplainedName::other_severities>({"that findings of a rule can have as well"}),
        field<&ExplainedName::summary>(), field<&ExplainedName::hint>(),
        field<&ExplainedName::examples>({"commands and lines of configurations"}));
  }
  std::string text() const {
    // The title of a rule names the check, not its result.
    auto out = fmt::format("{}{} ({})\n  {}{}\n  {}{}\n", name,
                           number ? fmt::format(" {}", *number) : "", severities(),
                           number ? "" : "checks: ", summary, number ? "" : "if it fails: ", hint);
    std::string_view before = "for example:";
    for (const auto& line : examples) {
      out += fmt::format("  {:<12}  {}\n", before, line);
      before = "";
    }
    return out;
  }

 private:
  // For example "error; note where --vendor does not name the products".
  std::string severities() const {
    auto out = severity;
    for (const auto& other : other_severities)
      out += fmt::format("; {} {}", other.severity, other.when);
    return out;
  }
};

ExplainedName about(const Row& row) {
  ExplainedName out{.name = std::string(row.name),
                    .number = {},
                    .severity = std::string(severity_of(row)),
                    .summary = std::string(row.summary),
                    .hint = std::string(row.hint)};
  if (row.number != 0) out.number = static_cast<std::size_t>(row.number);
  for (const auto& other : others_of(row))
    out.other_severities.push_back(
        {std::string(severity_word(other.severity)), std::string(other.when)});
  for (const auto line : examples_of(row.name)) out.examples.emplace_back(line);
  return out;
}

// The codes and rules that match a part of a name or number.
std::vector<Row> rows_with_name_part(const std::string& wanted) {
  constexpr std::size_t kMinSearchedPart = 2;  // characters of a part
  std::vector<Row> out;
  if (wanted.size() < kMinSearchedPart) return out;
  const bool is_number = std::ranges::all_of(wanted, [](char c) { return '0' <= c && c <= '9'; });
  for (const auto& code : all_codes()) {
    const auto number = static_cast<int>(code.code);
    const bool fits = is_number ? std::to_string(number).starts_with(wanted)
                                : ascii_upper(code.name).contains(wanted);
    if (fits) out.push_back({code.name, number, code.severity, code.summary, code.hint});
  }
  for (const auto& rule : all_rules())
    if (rule.id.contains(wanted)) out.push_back({rule.id, 0, rule.severity, rule.title, rule.hint});
  return out;
}

struct Match {
  std::string name;
  std::optional<std::size_t> number;
  std::string severity, summary;

  static constexpr auto fields() {
    return std::tuple(field<&Match::name>(), field<&Match::number>({.omits_empty = true}),
                      field<&Match::severity>({.def = "severity"}), field<&Match::summary>());
  }
  static Match of(const Row& row) {
    Match out{std::string(row.name), {}, std::string(severity_of(row)), std::string(row.summary)};
    if (row.number != 0) out.number = static_cast<std::size_t>(row.number);
    return out;
  }
};

struct Matches {
  static constexpr std::string_view kWhen = "of a part that several codes and rules have";
  std::vector<Match> matches = {};

  static constexpr auto fields() { return std::tuple(field<&Matches::matches>({.min = 2})); }
  std::string text() const {
    constexpr std::size_t kMax = 30;
    std::string out;
    for (const auto& one : matches | std::views::take(kMax))
      out += fmt::format("{:<32} {:<5} {}\n", one.name,
                         one.number ? std::to_string(*one.number) : "", one.summary);
    if (matches.size() > kMax) out += fmt::format("and {} more\n", matches.size() - kMax);
    return out + "ddssec explain NAME says more of one\n";
  }
};

struct Sentence {
  std::string product, sentence, meaning, look_with;

  static constexpr auto fields() {
    return std::tuple(field<&Sentence::product>({.words = "Cyclone DDS|ROS 2"}),
                      field<&Sentence::sentence>(), field<&Sentence::meaning>(),
                      field<&Sentence::look_with>());
  }
};

struct Sentences {
  static constexpr std::string_view kWhen = "of a sentence of Cyclone DDS or ROS 2";
  std::vector<Sentence> sentences = {};

  static constexpr auto fields() { return std::tuple(field<&Sentences::sentences>({.min = 1})); }
  std::string text() const {
    std::string out;
    for (const auto& one : sentences)
      out += fmt::format("{}: {}\n  {}\n  look with: {}\n", one.product, one.sentence, one.meaning,
                         one.look_with);
    return out;
  }
};

// A verdict of doctor and keystore verify. cli/README.md has the same table.
struct ExplainedVerdict {
  static constexpr std::string_view kWhen = "of a verdict of doctor";
  std::string verdict, meaning;

  static constexpr auto fields() {
    return std::tuple(field<&ExplainedVerdict::verdict>({.words = "ok|unsafe|late|fail"}),
                      field<&ExplainedVerdict::meaning>());
  }
  std::string text() const {
    return fmt::format(
        "{} (a verdict of doctor and keystore verify)\n  the product {}\n{}", verdict, meaning,
        verdict == "ok" ? "" : "  the finding of the check says why, and names what to do\n");
  }
};

constexpr std::array<std::pair<doctor::Outcome, std::string_view>, 4> kVerdictMeanings = {{
    {doctor::Outcome::ok, "accepts what was checked"},
    {doctor::Outcome::unsafe,
     "accepts it, although it should not: the participant starts with less security than intended"},
    {doctor::Outcome::late, "lets the participant start, and then refuses it or its endpoints"},
    {doctor::Outcome::fail, "does not start the participant"},
}};

std::optional<ExplainedVerdict> verdict_named(std::string_view wanted) {
  for (const auto& [outcome, meaning] : kVerdictMeanings)
    if (wanted == to_string(outcome))
      return ExplainedVerdict{std::string(to_string(outcome)), std::string(meaning)};
  return std::nullopt;
}

using Explanation = std::variant<ExplainedName, Sentences, Matches, ExplainedVerdict>;

Answer<Explanation> list_of(const std::vector<LogSentence>& found) {
  Sentences out;
  for (const auto& one : found)
    out.sentences.push_back({std::string(one.product), std::string(one.sentence),
                             std::string(one.meaning), std::string(one.look_with)});
  return {std::move(out)};
}

// The codes and rules whose sentence contains these words.
std::vector<Row> rows_with_words(const std::string& wanted) {
  std::vector<Row> out;
  for (const auto& code : all_codes())
    if (ascii_upper(code.summary).contains(wanted))
      out.push_back(
          {code.name, static_cast<int>(code.code), code.severity, code.summary, code.hint});
  for (const auto& rule : all_rules())
    if (ascii_upper(rule.title).contains(wanted))
      out.push_back({rule.id, 0, rule.severity, rule.title, rule.hint});
  return out;
}

// At most three names that contain the given one or almost do so. Upper and lower case and
// separators between words do not count.
std::vector<std::string> names_like(const std::string& wanted) {
  const auto bones = [](std::string_view name) {
    auto out = ascii_upper(name);
    std::erase_if(out, [](char c) { return c == '_' || c == '-' || c == ' '; });
    return out;
  };
  const auto meant = bones(wanted);
  std::vector<std::string> parts, all;
  const auto look = [&](std::string_view name) {
    all.push_back(bones(name));
    if (meant.size() >= kMinPartLength && all.back().contains(meant)) parts.emplace_back(name);
  };
  for (const auto& code : all_codes()) look(code.name);
  for (const auto& rule : all_rules()) look(rule.id);
  if (!parts.empty()) {
    parts.resize(std::min<std::size_t>(parts.size(), 3));
    return parts;
  }
  const auto near = nearest(meant, all);
  if (near.empty()) return {};
  for (const auto& code : all_codes())
    if (bones(code.name) == near) return {std::string(code.name)};
  return {near};  // the name of a rule has no separators
}

Answer<Explanation> about(const std::vector<Row>& rows) {
  if (rows.size() == 1) return {about(rows.front())};
  Matches out;
  std::ranges::transform(rows, std::back_inserter(out.matches), &Match::of);
  return {std::move(out)};
}

Result<Answer<Explanation>> explain(const Arguments& arguments, const Context&) {
  const auto wanted = arguments.text("CODE");
  if (const auto row = find_in_line(wanted)) return Answer<Explanation>{about(*row)};
  if (const auto row = find(without_brackets(wanted))) return Answer<Explanation>{about(*row)};
  if (auto verdict = verdict_named(ascii_lower(wanted)))
    return Answer<Explanation>{*std::move(verdict)};
  if (wanted.contains(' ')) {
    if (const auto found = log_sentences_like(wanted); !found.empty()) return list_of(found);
    if (const auto rows = rows_with_words(ascii_upper(wanted)); !rows.empty()) return about(rows);
  }
  if (const auto rows = rows_with_name_part(without_brackets(wanted)); !rows.empty())
    return about(rows);
  if (const auto found = log_sentences_like(wanted); !found.empty()) return list_of(found);
  return fail(
      Code::usage,
      {.field = "CODE",
       .expected = "a name or number as messages show it in brackets, or a part of one, or of "
                   "a sentence of ddssec, Cyclone DDS or ROS 2; or a verdict of doctor",
       .found =
           '"' + wanted.substr(0, 64) + '"' + did_you_mean(names_like(without_brackets(wanted)))});
}

}  // namespace

std::vector<Command> explain_commands() {
  return {
      {.group = "",
       .name = "explain",
       .summary = "Says what a code means and what to do about it.",
       .positionals = {{"CODE",
                        "its name or number, a part of one, a part of a sentence, also of "
                        "Cyclone DDS and ROS 2, a whole line of a log, or a verdict of doctor"}},
       .options = {},
       .examples = {"ddssec explain no_grant_for_subject", "ddssec explain 1242",
                    "ddssec explain 124", "ddssec explain late", "ddssec explain 'not allowed'"},
       .run = explain}};
}

}  // namespace ddssec::cli
