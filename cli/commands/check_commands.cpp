// check: would two participants talk, and which line decides?
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "cli/commands/groups.hpp"
#include "cli/doctor/doctor_options.hpp"
#include "cli/doctor/meeting_report.hpp"
#include "cli/doctor/pre_shared_keys.hpp"
#include "cli/doctor/products.hpp"
#include "cli/doctor/renewal_list_check.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/stock_spelling.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

// "A=cyclonedds" sets products[0] and "B=..." products[1]; a name alone sets both.
Status set_product(const std::string& word, doctor::NamedProduct (&products)[2]) {
  const bool is_a = word.starts_with("A=");
  const bool is_b = word.starts_with("B=");
  const auto product = doctor::named_product_from(is_a || is_b ? word.substr(2) : word);
  if (!product) return unknown_product_error(word, "A= or B= and ");
  if (!is_b) products[0] = *product;
  if (!is_a) products[1] = *product;
  return {};
}

// A participant that runs this product.
doctor::Party party(const doctor::LoadedFolder& folder, const doctor::NamedProduct& product,
                    const std::string& name, Report& report) {
  doctor::Party out{folder, product.name, name};
  if (product.name != doctor::Product::ddssec)
    out.lineup.of(product.name) = version_of(product, report);
  return out;
}

Result<WantedDirections> wanted_directions(const Arguments& arguments) {
  const auto word = arguments.text("--require");
  if (word == "any") return WantedDirections::any;
  if (word == "both") return WantedDirections::both;
  if (word == "writer=A") return WantedDirections::writer_a;
  if (word == "writer=B") return WantedDirections::writer_b;
  return fail(Code::usage, {.field = "--require",
                            .expected = "any, both, writer=A or writer=B",
                            .found = '"' + word + '"'});
}

void add_parts(std::string_view text, std::vector<std::string>& out) {
  while (!text.empty()) {
    const auto end = std::min(text.find(','), text.size());
    if (end > 0) out.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

// Without this check, a missing file would count as a topic with its name. A word with a comma is a
// list of names.
bool looks_like_a_file(const std::string& word) {
  if (word.find(',') != word.npos) return false;
  constexpr std::string_view kEndings[] = {".txt", ".lst", ".list", ".csv", ".topics"};
  return word.starts_with("./") || word.starts_with("../") || word.starts_with("~/") ||
         std::ranges::any_of(kEndings, [&](auto ending) { return word.ends_with(ending); });
}

std::unexpected<Error> unknown_list_error(const std::string& word) {
  return fail(
      Code::file_not_found,
      {.document = word,
       .field = "--topics",
       .expected = "a file with a topic on each line",
       .hint = fmt::format("for a topic of this name, put a comma behind it: --topics {},", word)});
}

// Reads names separated by commas, or a file with one name on each line.
Result<std::vector<std::string>> checked_topics(const Arguments& arguments) {
  std::vector<std::string> out;
  for (const auto& word : arguments.all("--topics")) {
    std::error_code ignored;
    if (fs::is_regular_file(word, ignored)) {
      DDSSEC_ASSIGN_OR_RETURN(const auto topics, read_topics(word));
      out.insert(out.end(), topics.begin(), topics.end());
    } else if (looks_like_a_file(word)) {
      return unknown_list_error(word);
    } else {
      add_parts(word, out);
    }
  }
  const bool is_bad = (arguments.has("--topics") && out.empty()) || out.size() > doctor::kMaxTopics;
  if (is_bad)
    return fail(Code::usage, {.field = "--topics",
                              .expected = fmt::format("1 to {} names", doctor::kMaxTopics),
                              .found = std::to_string(out.size())});
  return out;
}

Report unpredictable_report(const fs::path& file, doctor::Product product) {
  auto report = cli::report_of(
      Error(Code::file_unreadable,
            {.document = file,
             .note = fmt::format("{0} may start with it, and ddssec does not read it as {0} does: "
                                 "whether they would talk is not known",
                                 doctor::family(product)),
             .hint = "ddssec doctor says what is wrong with it"}));
  report.exit = Exit::unreadable;
  return report;
}

// Explains why there is no answer: the product accepts a file that ddssec cannot judge, such as a
// certificate with a key of another curve, so a "no" could be seriously wrong. Empty if an answer
// is possible.
std::optional<Report> unpredictable_report(const doctor::LoadedFolder& folder,
                                           doctor::Product product) {
  const auto& certificate = folder.certificate;
  if (const auto* file = doctor::unpredictable_file(folder, product))
    return unpredictable_report(*file, product);
  if (product != doctor::Product::cyclonedds || certificate ||
      !doctor::is_key_of_another_curve(certificate.error()))
    return std::nullopt;
  auto details = certificate.error().details();
  details.document = folder.paths.certificate;
  details.note =
      "Cyclone DDS takes any EC key of 256 bits and ddssec does not read this one: "
      "whether they would talk is not known";
  auto report = cli::report_of(Error(Code::key_not_allowed, std::move(details)));
  report.exit = Exit::unreadable;
  return report;
}

// The answer is about ddssec on both sides, so what another product does is only a warning.
void warn_of_readings(std::initializer_list<const doctor::LoadedFolder*> folders,
                      const doctor::Settings& settings, Report& report) {
  for (const auto* folder : folders) {
    doctor::Diagnosis readings(settings.lineup);
    doctor::diagnose_readings(*folder, settings, readings);
    for (const auto& one : readings.checks())
      for (auto finding : one.findings) {
        finding.severity = Severity::warning;
        report.findings.push_back(std::move(finding));
      }
  }
}

// The first meeting of two participants needs no renewal list, so these findings do not change the
// answer.
void warn_of_renewal_lists(
    const std::pair<const doctor::LoadedFolder*, doctor::Product> (&sides)[2],
    const doctor::Settings& settings, Report& report) {
  for (const auto& [folder, product] : sides) {
    if (product != doctor::Product::ddssec) continue;
    doctor::Diagnosis lists(settings.lineup);
    diagnose_renewal_list(*folder, settings, lists);
    for (const auto& one : lists.checks())
      report.findings.insert(report.findings.end(), one.findings.begin(), one.findings.end());
  }
}

Result<Answer<MeetingView>> check(const Arguments& arguments, const Context& context) {
  const fs::path folders[] = {arguments.text("A"), arguments.text("B")};
  doctor::NamedProduct products[] = {{doctor::Product::ddssec}, {doctor::Product::ddssec}};
  for (const auto& word : arguments.all("--vendor"))
    DDSSEC_RETURN_IF_ERROR(set_product(word, products));
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, wanted_directions(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto topics, checked_topics(arguments));
  for (const auto& folder : folders) DDSSEC_RETURN_IF_ERROR(check_participant_folder(folder));

  const auto now = context.clock.calendar_seconds();
  using Kept = std::shared_ptr<const doctor::LoadedFolder>;
  const Kept kept[] = {
      std::make_shared<const doctor::LoadedFolder>(load_participant(folders[0], now)),
      std::make_shared<const doctor::LoadedFolder>(load_participant(folders[1], now))};
  const auto& a = *kept[0];
  const auto& b = *kept[1];
  // If ddssec is among the products, the answer is no, because it refuses to start with such files.
  const bool are_stock = std::ranges::none_of(
      products, [](const auto& one) { return one.name == doctor::Product::ddssec; });
  for (const auto& [folder, product] : {std::pair{&a, &products[0]}, std::pair{&b, &products[1]}})
    if (auto unknown = are_stock ? unpredictable_report(*folder, product->name) : std::nullopt)
      return Answer<MeetingView>{{}, *std::move(unknown), false};
  Report report;
  DDSSEC_ASSIGN_OR_RETURN(const auto domain, domain_for(arguments, {&a, &b}, now, report));
  std::string names[2];
  name_parties(folders[0], folders[1], names);
  MeetingView view{
      .meeting = predict_with_properties(
          party(a, products[0], names[0], report), party(b, products[1], names[1], report),
          {.now = now,
           .domain = domain,
           .partitions = arguments.all("--partition"),
           .writes = {wanted == WantedDirections::both || wanted == WantedDirections::writer_a,
                      wanted == WantedDirections::both || wanted == WantedDirections::writer_b},
           .may_run_elsewhere = true},
          topics),
      .names = {names[0], names[1]},
      .domain = domain,
      .topics_named = !topics.empty(),
      .wanted = wanted,
      .explain = arguments.has("--explain"),
      .kept = {kept[0], kept[1]}};
  const auto& meeting = view.meeting;
  // A topic that both may use but cannot is an error even if another topic works.
  report.exit = view.talk() && !has_topic_apart(meeting) ? Exit::done : Exit::no;
  report.findings.insert(report.findings.end(), meeting.findings.begin(), meeting.findings.end());
  // DOC083 is about products that --vendor did not name, so only --explain shows it.
  const bool asked = arguments.has("--explain") && !arguments.has("--vendor");
  std::ranges::copy_if(meeting.notes, std::back_inserter(report.findings),
                       [&](const Finding& note) { return asked || note.rule != Rule::DOC083; });
  const doctor::Settings settings{.now = now, .domain = domain, .lineup = installed_lineup()};
  if (!arguments.has("--vendor")) warn_of_readings({&a, &b}, settings, report);
  warn_of_renewal_lists({{&a, products[0].name}, {&b, products[1].name}}, settings, report);
  return Answer<MeetingView>{std::move(view), std::move(report)};
}

}  // namespace

std::vector<Command> check_commands() {
  return {
      {.group = "",
       .name = "check",
       .summary = "Says whether two participants would talk, and which line decides; exit 1: no.",
       .positionals = {{"A", "a participant's folder"}, {"B", "another's"}},
       .options = {repeated("--topics", "LIST",
                            "names with commas between them, or a file with one on each line"),
                   kDomainToCheck,
                   repeated("--partition", "P", "a partition of writers and readers"),
                   repeated("--vendor", "WHO",
                            "A= or B= and cyclonedds, fastdds (with @VERSION if another than the "
                            "installed one matters) or ddssec (without: ddssec)"),
                   {"--require", "WHAT", "any, both, writer=A or writer=B on every topic", "any"},
                   {"--explain", "", "every judgement, not only those that refuse"}},
       .examples = {"ddssec check demo/talker demo/listener",
                    "ddssec check talker listener --topics rt/chatter --vendor A=cyclonedds "
                    "--vendor B=fastdds"},
       .run = check}};
}

}  // namespace ddssec::cli
