// Warns when signed permissions may be extended past the end that the user gave (by the agent, or
// by `identity renew --permissions`), or are not those that the participant uses.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "cli/ca/ca_folder.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// Adds notices (notices.hpp) about permissions that were signed for the file `to`. `given` is the
/// folder of --ca.
/// - end_not_final: the participant in whose folder they are has a certificate that ends later, so
///   its permissions may be extended up to that end.
/// - signed_elsewhere: the CA signed permissions for a participant's folder before, and these are
///   for the same subject but for another file. So those in the folder stay current.
/// Nothing is noted if a log or the certificate cannot be read.
void warn_of_extension(const governance::Permissions& document, const std::filesystem::path& to,
                       const std::filesystem::path& given, WallTime now);

}  // namespace ddssec::cli
