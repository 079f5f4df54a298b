#include "cli/granted_domains.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/documents.hpp"
#include "governance/doctor/domains.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;

bool have_any_in_common(const doctor::Domains& a, const doctor::Domains& b) {
  return std::ranges::any_of(a, [&](const auto& one) {
    return std::ranges::any_of(
        b, [&](const auto& other) { return one.first <= other.last && other.first <= one.last; });
  });
}

}  // namespace

Result<std::vector<governance::DomainRange>> granted_domains(
    const Arguments& arguments, const std::filesystem::path& governance,
    std::vector<Finding>& findings) {
  doctor::Domains covered;
  if (const auto document = unverified_document<GovernanceKind>(governance); document)
    for (const auto& rule : document->domain_rules)
      covered.insert(covered.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
  covered = doctor::normal(std::move(covered));
  if (!arguments.has("--domain"))
    return covered.empty() ? std::vector<governance::DomainRange>{{0, 0}} : covered;
  DDSSEC_ASSIGN_OR_RETURN(auto given, domain_ranges(arguments, "--domain"));
  if (!covered.empty() && !have_any_in_common(given, covered))
    findings.push_back(
        {.rule = Rule::DOC050,
         .message = fmt::format("the permissions are for domain {}, and the governance document "
                                "is for {}: the participant cannot start",
                                doctor::in_words(given), doctor::in_words(covered)),
         .document = governance.string(),
         .severity = Severity::warning});
  return given;
}

}  // namespace ddssec::cli
