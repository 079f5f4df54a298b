// doctor: everything that is wrong with a participant's folder, for each product.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/doctor_options.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/key_limits.hpp"
#include "cli/meeting_report.hpp"
#include "cli/options.hpp"
#include "cli/pre_shared_keys.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/domains.hpp"
#include "governance/doctor/lint_checks.hpp"
#include "governance/doctor/plugin_probe.hpp"
#include "governance/doctor/ros.hpp"
#include "governance/doctor/shared_memory.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;
using doctor::Vendor;

using Vendors = std::vector<Vendor>;

// What --vendor says; all of them if it is not given.
Result<Vendors> chosen_vendors(const Arguments& arguments) {
  Vendors out;
  for (const auto& word : arguments.all("--vendor")) {
    if (word == "all") return Vendors(doctor::kVendors.begin(), doctor::kVendors.end());
    const auto vendor = doctor::vendor_from(word);
    if (!vendor) return unknown_vendor(word, "all, ");
    out.push_back(*vendor);
  }
  if (out.empty()) out.assign(doctor::kVendors.begin(), doctor::kVendors.end());
  return out;
}

// What concerns products that have no column (OpenDDS) is told if nobody chose.
bool concerns(const Finding& finding, const Vendors& vendors) {
  return finding.vendors.empty() || std::ranges::any_of(finding.vendors, [&](const auto& word) {
           const auto vendor = doctor::vendor_from(word);
           return vendor ? std::ranges::find(vendors, *vendor) != vendors.end()
                         : vendors.size() == doctor::kVendors.size();
         });
}

Json verdicts(const doctor::Outcomes& outcomes, const Vendors& vendors) {
  Json out = Json::object();
  for (const auto vendor : vendors)
    out[std::string(doctor::id(vendor))] = to_string(outcomes.of(vendor));
  return out;
}

Json to_json(const doctor::Check& check, const Vendors& vendors) {
  Json out = {{"id", info(check.rule).id},
              {"title", check.title},
              {"verdicts", verdicts(check.outcomes, vendors)}};
  const auto said = std::ranges::find_if(
      check.findings, [&](const Finding& finding) { return concerns(finding, vendors); });
  if (said != check.findings.end())
    out["fix"] = said->hint.empty() ? std::string(info(check.rule).hint) : said->hint;
  return out;
}

constexpr std::size_t kTitleWidth = 54;
constexpr std::size_t kColumnWidth = 19;

std::string row(std::string_view title, const doctor::Outcomes& outcomes, const Vendors& vendors) {
  auto out = fmt::format("{:<{}} ", title, kTitleWidth);
  for (const auto vendor : vendors)
    out += fmt::format("{:<{}}", to_string(outcomes.of(vendor)), kColumnWidth);
  return out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
}

std::string table(const doctor::Diagnosis& diagnosis, std::string_view title,
                  const Vendors& vendors) {
  auto out = fmt::format("{:<{}} ", title, kTitleWidth);
  for (const auto vendor : vendors)
    out += fmt::format("{:<{}}", doctor::label(vendor), kColumnWidth);
  out = out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
  for (const auto& check : diagnosis.checks()) out += row(check.title, check.outcomes, vendors);
  return out + row("in all", diagnosis.outcomes(), vendors);
}

// The findings that concern the chosen products.
std::vector<Finding> findings_for(const Vendors& vendors, const doctor::Diagnosis& diagnosis) {
  std::vector<Finding> out;
  for (const auto& check : diagnosis.checks())
    std::ranges::copy_if(check.findings, std::back_inserter(out),
                         [&](const Finding& finding) { return concerns(finding, vendors); });
  return out;
}

bool is_good(const doctor::Diagnosis& diagnosis, const Vendors& vendors) {
  const auto outcomes = diagnosis.outcomes();
  return std::ranges::all_of(
      vendors, [&](Vendor vendor) { return outcomes.of(vendor) == doctor::Outcome::ok; });
}

Json ids(const Vendors& vendors) {
  Json out = Json::array();
  for (const auto vendor : vendors) out.push_back(doctor::id(vendor));
  return out;
}

/// What one folder comes to; findings and text are added to the report.
Json add_diagnosis(Report& report, const fs::path& folder, const doctor::Diagnosis& diagnosis,
                   const doctor::Settings& settings, const Vendors& vendors) {
  auto findings = findings_for(vendors, diagnosis);
  const auto count = counted(findings);
  add_findings(report, std::move(findings), folder);
  if (!is_good(diagnosis, vendors)) report.exit = Exit::no;
  report.text +=
      table(diagnosis, fmt::format("{}, domain {}", folder.string(), settings.domain), vendors) +
      count + '\n';
  Json out = {{"vendors", ids(vendors)}, {"checks", Json::array()}};
  for (const auto& check : diagnosis.checks()) out["checks"].push_back(to_json(check, vendors));
  out["verdicts"] = verdicts(diagnosis.outcomes(), vendors);
  return out;
}

// Each product of the one with each product of the other. That two products do not understand each
// other is a "no" only if somebody asked for the two.
void add_meetings(Report& report, const doctor::Party& self, const doctor::Party& peer,
                  const doctor::Settings& settings, const Vendors& vendors, bool products_chosen) {
  report.result["peer"]["meetings"] = Json::array();
  std::vector<std::string> said;
  for (const auto a : vendors)
    for (const auto b : vendors) {
      const auto meeting =
          meet_with_keys({self.folder, a, self.name}, {peer.folder, b, peer.name}, settings);
      const MeetingView view{
          .meeting = meeting, .names = {self.name, peer.name}, .domain = settings.domain};
      const bool talk = would_talk(view);
      if (!talk && (a == b || products_chosen)) report.exit = Exit::no;
      report.text += fmt::format("{} on {}, {} on {}: {}\n", self.name, doctor::label(a), peer.name,
                                 doctor::label(b), talk ? "they talk" : "they do NOT talk");
      report.result["peer"]["meetings"].push_back(
          {{"self", doctor::id(a)}, {"peer", doctor::id(b)}, {"talk", talk}});
      auto findings = meeting.findings;
      std::ranges::copy_if(meeting.notes, std::back_inserter(findings), [](const auto& note) {
        return note.rule == Rule::DOC094;  // the others are of this pair alone
      });
      for (const auto& finding : findings) {
        if (finding.rule == Rule::DOC090 || finding.rule == Rule::DOC091 ||
            finding.rule == Rule::DOC093)
          continue;  // said by the diagnosis
        if (std::ranges::find(said, finding.message) != said.end()) continue;
        said.push_back(finding.message);
        report.findings.push_back(finding);
      }
    }
}

void add_peer(Report& report, const Arguments& arguments, const doctor::LoadedFolder& self,
              const doctor::LoadedFolder& peer, const doctor::Settings& settings,
              const Vendors& vendors) {
  const fs::path folders[] = {arguments.text("DIR"), arguments.text("--peer")};
  report.text += '\n';
  auto diagnosis = doctor::diagnose(peer, settings);
  check_pre_shared_keys(peer, settings, diagnosis);
  check_key_limits(peer, settings, diagnosis);
  doctor::check_lint(peer, settings, diagnosis);
  report.result["peer"] = add_diagnosis(report, folders[1], diagnosis, settings, vendors);
  std::string names[2];
  name_parties(folders[0], folders[1], names);
  report.text += '\n';
  add_meetings(report, {self, Vendor::ours, names[0]}, {peer, Vendor::ours, names[1]}, settings,
               vendors, arguments.has("--vendor"));
}

// A node of ROS 2 asks its environment only, and runs in domain 0 if that names none.
Result<DomainId> ros_domain() {
  const auto environment = doctor::ros_environment();
  const auto found = environment.find("ROS_DOMAIN_ID");
  if (found == environment.end() || found->second.empty()) return DomainId{0};
  const Arguments from_environment({{"ROS_DOMAIN_ID", {found->second}}});
  const auto number = from_environment.number("ROS_DOMAIN_ID", 0, governance::kHighestDomainId);
  if (number) return static_cast<DomainId>(*number);
  auto details = number.error().details();
  details.field = "the environment variable ROS_DOMAIN_ID";
  return fail(number.error().code(), std::move(details));
}

// The domain of the node; where the documents are for others, one of those, so that the wrong
// variable (DOC096) is not said again for each piece of them.
Result<DomainId> domain_of_node(const doctor::LoadedFolder& folder, WallTime now) {
  const auto domain = DDSSEC_TRY(ros_domain());
  const auto named = doctor::domains_of(folder, now);
  if (named.empty() || doctor::contains(named, domain)) return domain;
  const doctor::Domains participants[] = {named};
  return doctor::choose_domain(participants).domain;
}

Result<Report> doctor_of(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("DIR");
  const auto vendors = DDSSEC_TRY(chosen_vendors(arguments));
  const auto now = context.clock.now();
  DDSSEC_TRY(check_folder(folder));
  const auto loaded = load_participant(folder, now);
  std::optional<doctor::LoadedFolder> peer;
  if (arguments.has("--peer")) {
    DDSSEC_TRY(check_folder(arguments.text("--peer")));
    peer = load_participant(arguments.text("--peer"), now);
  }
  Report report;
  const bool is_of_ros = arguments.has("--ros") && !arguments.has("--domain");
  const auto domain = DDSSEC_TRY(
      is_of_ros ? domain_of_node(loaded, now)
                : domain_for(arguments, {&loaded, peer ? &*peer : &loaded}, now, report));
  const doctor::Settings settings{.now = now, .domain = domain};
  auto diagnosis = doctor::diagnose(loaded, settings);
  check_pre_shared_keys(loaded, settings, diagnosis);
  check_key_limits(loaded, settings, diagnosis);
  if (arguments.has("--ros"))
    doctor::check_ros(loaded, doctor::ros_environment(), settings, diagnosis);
  if (arguments.has("--plugins"))
    doctor::check_plugins(
        arguments.text("--plugins") == "system" ? "" : arguments.text("--plugins"), diagnosis);
  doctor::check_shared_memory(loaded, doctor::cyclonedds_configuration(), settings, diagnosis);
  doctor::check_lint(loaded, settings, diagnosis);
  report.result = {{"domain", domain}};
  report.result.update(add_diagnosis(report, folder, diagnosis, settings, vendors));
  if (peer) add_peer(report, arguments, loaded, *peer, settings, vendors);
  return report;
}

}  // namespace

// The folder of several participants, given in place of one of theirs, is a likely mistake.
Status check_folder(const fs::path& folder) {
  DDSSEC_TRY(check_directory(folder, "a participant's folder"));
  const auto files = pki::participant_folder(folder);
  if (is_there(files.certificate) || is_there(files.identity_ca)) return {};
  constexpr std::size_t kMost = 5;
  std::vector<std::string> inside;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_there(entry.path() / "cert.pem")) inside.push_back(entry.path().string());
  if (inside.empty()) return {};
  std::ranges::sort(inside);
  const bool more = inside.size() > kMost;
  if (more) inside.resize(kMost);
  return fail(Code::file_not_found,
              {.document = files.certificate,
               .note = fmt::format("{} holds participants: {}{}", folder.string(),
                                   fmt::join(inside, ", "), more ? ", ..." : "")});
}

doctor::LoadedFolder load_participant(const fs::path& folder, WallTime now) {
  return doctor::load_folder(pki::participant_folder(folder), now);
}

std::unexpected<Error> unknown_vendor(const std::string& word, std::string_view before) {
  const bool names_version = word.find('@') != word.npos;
  return fail(Code::usage,
              {.field = "--vendor",
               .expected = fmt::format("{}cyclonedds@0.10.2, fastdds@2.9.1 or ddssec", before),
               .found = '"' + word + '"',
               .note = names_version ? "no other version was measured; what is known of Fast DDS "
                                       "2.10 and later is in docs/why-they-do-not-talk.md"
                                     : ""});
}

Result<DomainId> domain_for(const Arguments& arguments,
                            std::initializer_list<const doctor::LoadedFolder*> folders,
                            WallTime now, Report& report) {
  if (arguments.has("--domain")) return domain_of(arguments);
  std::vector<doctor::Domains> domains;
  for (const auto* folder : folders) domains.push_back(domains_of(*folder, now));
  const auto choice = doctor::choose_domain(domains);
  if (choice.has_others())
    report.findings.push_back(
        {.rule = Rule::DOC095,
         .message = fmt::format("the documents are for domains {}; domain {} was checked",
                                doctor::in_words(choice.named), choice.domain)});
  return choice.domain;
}

void name_parties(const fs::path& a, const fs::path& b, std::string (&names)[2]) {
  names[0] = folder_name(a);
  names[1] = folder_name(b);
  if (names[0] != names[1]) return;
  names[0] = a.string();
  names[1] = b.string();
}

std::vector<Command> doctor_commands() {
  return {
      {.group = "",
       .name = "doctor",
       .summary = "Finds what is wrong with a participant's folder, for each product; exit 1 if "
                  "something is.",
       .positionals = {{"DIR", "the participant's folder, flat or an enclave of sros2"}},
       .options = {kDomainToCheck,
                   repeated("--vendor", "V", "all, cyclonedds@0.10.2, fastdds@2.9.1 or ddssec"),
                   {"--peer", "DIR", "another participant: would they talk?"},
                   {"--ros", "", "as an enclave of ROS 2, with its variables and ROS_DOMAIN_ID"},
                   {"--plugins", "WHERE",
                    "load the plugin libraries of this folder, or (system) Cyclone DDS's"}},
       .examples = {"ddssec doctor demo/talker", "ddssec doctor talker --vendor fastdds",
                    "ddssec doctor talker --peer listener"},
       .run = doctor_of}};
}

}  // namespace ddssec::cli
