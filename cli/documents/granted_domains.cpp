#include "cli/documents/granted_domains.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/documents/documents.hpp"
#include "governance/doctor/domains_of_folder.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;

bool have_any_in_common(const doctor::Domains& a, const doctor::Domains& b) {
  return std::ranges::any_of(a, [&](const auto& one) {
    return std::ranges::any_of(
        b, [&](const auto& other) { return one.first <= other.last && other.first <= one.last; });
  });
}

doctor::Domains covered_by(const std::filesystem::path& governance) {
  doctor::Domains out;
  if (const auto document = unverified_document<GovernanceKind>(governance); document)
    for (const auto& rule : document->domain_rules)
      out.insert(out.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
  return doctor::merged(std::move(out));
}

}  // namespace

std::vector<Finding> uncovered_grants(const governance::Permissions& permissions,
                                      const std::filesystem::path& governance,
                                      const std::filesystem::path& file) {
  const auto covered = covered_by(governance);
  std::vector<Finding> out;
  for (const auto& grant : permissions.grants) {
    doctor::Domains allowed;
    int line = grant.line;
    for (const auto& rule : grant.rules) {
      if (!rule.allow) continue;
      if (allowed.empty()) line = rule.domains.line;
      allowed.insert(allowed.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
    }
    allowed = doctor::merged(std::move(allowed));
    if (covered.empty() || allowed.empty() || grant.default_allow ||
        have_any_in_common(allowed, covered))
      continue;
    out.push_back(
        {.rule = Rule::DOC050,
         .message = fmt::format(
             "grant \"{}\" allows only domain {}, and {} covers only {}: the participant "
             "cannot start with it, and takes it if it runs",
             grant.name, doctor::to_text(allowed), governance.string(), doctor::to_text(covered)),
         .document = file.string(),
         .line = line,
         .hint =
             fmt::format("write permissions for domain {} and sign them", doctor::to_text(covered)),
         .severity = Severity::warning});
  }
  return out;
}

Result<std::vector<governance::DomainRange>> granted_domains(
    const Arguments& arguments, const std::filesystem::path& governance,
    std::vector<Finding>& findings) {
  const auto covered = covered_by(governance);
  if (!arguments.has("--domain"))
    return covered.empty() ? std::vector<governance::DomainRange>{{0, 0}} : covered;
  DDSSEC_ASSIGN_OR_RETURN(auto given, domain_ranges(arguments, "--domain"));
  if (!covered.empty() && !have_any_in_common(given, covered))
    findings.push_back(
        {.rule = Rule::DOC050,
         .message = fmt::format("the permissions are for domain {}, and the governance document "
                                "is for {}: the participant cannot start",
                                doctor::to_text(given), doctor::to_text(covered)),
         .document = governance.string(),
         .severity = Severity::warning});
  return given;
}

}  // namespace ddssec::cli
