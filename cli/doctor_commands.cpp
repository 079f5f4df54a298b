// doctor: everything that is wrong with a participant's folder, for each product.
#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "cli/groups.hpp"
#include "cli/options.hpp"
#include "governance/doctor/diagnosis.hpp"
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
    if (!vendor)
      return fail(Code::usage, {.field = "--vendor",
                                .expected = "all, cyclonedds@0.10.2, fastdds@2.9.1 or ours",
                                .found = '"' + word + '"'});
    out.push_back(*vendor);
  }
  if (out.empty()) out.assign(doctor::kVendors.begin(), doctor::kVendors.end());
  return out;
}

Status check_folder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) return {};
  return fail(Code::file_not_found, {.document = folder, .expected = "a participant's folder"});
}

bool concerns(const Finding& finding, const Vendors& vendors) {
  return finding.vendors.empty() || std::ranges::any_of(vendors, [&](Vendor vendor) {
           return std::ranges::find(finding.vendors, doctor::id(vendor)) != finding.vendors.end();
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

constexpr std::size_t kTitleWidth = 50;
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
  for (const auto vendor : vendors) out += fmt::format("{:<{}}", doctor::id(vendor), kColumnWidth);
  out = out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
  for (const auto& check : diagnosis.checks()) out += row(check.title, check.outcomes, vendors);
  return out + row("in all", diagnosis.outcomes(), vendors);
}

// The findings that concern the chosen products; how many of them are more than a warning.
std::size_t add_findings(Report& report, const doctor::Diagnosis& diagnosis,
                         const Vendors& vendors) {
  for (const auto& check : diagnosis.checks())
    for (const auto& finding : check.findings)
      if (concerns(finding, vendors)) report.findings.push_back(finding);
  return static_cast<std::size_t>(std::ranges::count_if(
      report.findings, [](const Finding& f) { return f.severity >= Severity::error; }));
}

std::string summary(std::size_t problems, std::size_t findings) {
  const auto plural = [](std::size_t n, std::string_view word) {
    return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s");
  };
  return fmt::format("{}, {}\n", plural(problems, "problem"),
                     plural(findings - problems, "warning"));
}

Result<Report> doctor_of(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("DIR");
  const auto vendors = DDSSEC_TRY(chosen_vendors(arguments));
  const auto domain = static_cast<DomainId>(
      DDSSEC_TRY(arguments.number("--domain", 0, governance::kHighestDomainId)));
  DDSSEC_TRY(check_folder(folder));
  const auto now = context.clock.now();
  const auto loaded = doctor::load_folder(pki::participant_folder(folder), now);
  const auto diagnosis = doctor::diagnose(loaded, {.now = now, .domain = domain});

  Report report;
  const auto problems = add_findings(report, diagnosis, vendors);
  const auto outcomes = diagnosis.outcomes();
  const bool good = std::ranges::all_of(
      vendors, [&](Vendor vendor) { return outcomes.of(vendor) == doctor::Outcome::ok; });
  report.exit = good ? Exit::done : Exit::no;
  report.text = table(diagnosis, fmt::format("{}, domain {}", folder.string(), domain), vendors) +
                summary(problems, report.findings.size());
  report.result = {{"vendors", Json::array()}, {"checks", Json::array()}};
  for (const auto vendor : vendors) report.result["vendors"].push_back(doctor::id(vendor));
  for (const auto& check : diagnosis.checks())
    report.result["checks"].push_back(to_json(check, vendors));
  report.result["verdicts"] = verdicts(outcomes, vendors);
  return report;
}

}  // namespace

std::vector<Command> doctor_commands() {
  return {{.group = "",
           .name = "doctor",
           .summary =
               "Finds what is wrong with a participant's folder, for each product; exit 1 if "
               "something is.",
           .positionals = {{"DIR", "the participant's folder, flat or an enclave of sros2"}},
           .options = {kDomain,
                       repeated("--vendor", "V", "all, cyclonedds@0.10.2, fastdds@2.9.1 or ours")},
           .examples = {"ddssec doctor demo/talker", "ddssec doctor talker --vendor fastdds"},
           .run = doctor_of}};
}

}  // namespace ddssec::cli
