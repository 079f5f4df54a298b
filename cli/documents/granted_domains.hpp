// Chooses the domains for which new permissions are granted.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/frame/command.hpp"
#include "cli/frame/report.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// Returns the values of --domain, or else all domains of the governance document in `governance`,
/// or else domain 0. If --domain has no domain in common with the governance document, `findings`
/// get DOC050, because the participant would not start. The document is not verified, because it
/// only provides a default. Error: usage.
Result<std::vector<governance::DomainRange>> granted_domains(
    const Arguments& arguments, const std::filesystem::path& governance,
    std::vector<Finding>& findings);

/// Returns DOC050 as a warning for each grant that allows no domain of the governance document: a
/// participant with such a grant cannot start, and a running one loses its rights. Empty if there
/// is no governance document. The document is not verified.
std::vector<Finding> uncovered_grants(const governance::Permissions& permissions,
                                      const std::filesystem::path& governance,
                                      const std::filesystem::path& file);

}  // namespace ddssec::cli
