// Finds grants whose subject is probably mistyped.
#pragma once

#include <filesystem>
#include <vector>

#include "base/finding.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// Returns a warning (DOC010) for each grant whose subject has no certificate in the log of the
/// identity CA below `ca`, although the log has one for a similar subject. Subjects that differ in
/// digits alone are not similar, because fleets have such names. Empty if there is no such log;
/// `file` is the document. At most kMaxMistypedSubjects are returned.
inline constexpr std::size_t kMaxMistypedSubjects = 4;
std::vector<Finding> mistyped_subjects(const governance::Permissions& permissions,
                                       const std::filesystem::path& ca,
                                       const std::filesystem::path& file);

}  // namespace ddssec::cli
