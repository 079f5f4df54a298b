// The domains that new permissions are for.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/command.hpp"
#include "cli/report.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// What --domain says; else all domains that the governance document in `governance` is for; else
/// domain 0. Outside of these a participant would not start, which `findings` say (DOC050). The
/// document is not verified: it only proposes. Error: usage.
Result<std::vector<governance::DomainRange>> granted_domains(
    const Arguments& arguments, const std::filesystem::path& governance,
    std::vector<Finding>& findings);

}  // namespace ddssec::cli
