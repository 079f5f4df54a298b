// The domains for which new permissions are granted.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/frame/command.hpp"
#include "cli/frame/report.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// The values of --domain; otherwise all domains of the governance document in `governance`;
/// otherwise domain 0. Outside of these a participant would not start; `findings` then get DOC050.
/// The document is not verified, because it only provides a default. Error: usage.
Result<std::vector<governance::DomainRange>> granted_domains(
    const Arguments& arguments, const std::filesystem::path& governance,
    std::vector<Finding>& findings);

/// DOC050 as a warning for each grant that allows no domain of the governance document: a
/// participant with it cannot start, and one that runs loses its rights. Empty if there is no such
/// document. It is not verified.
std::vector<Finding> uncovered_grants(const governance::Permissions& permissions,
                                      const std::filesystem::path& governance,
                                      const std::filesystem::path& file);

}  // namespace ddssec::cli
