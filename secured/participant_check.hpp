// Checks that a folder belongs to a participant. If it does not, the error suggests what may have
// been meant.
#pragma once

#include <filesystem>

#include "base/result.hpp"

namespace ddssec::secured {

/// Success if `given` is a folder that contains a participant's certificate or CA certificate, and
/// also for a folder that is none of the cases below.
/// Errors: file_not_found (`given` does not exist, is the folder of a CA, or contains participants'
/// folders), file_unreadable (`given` is not a folder). The error names participants' folders that
/// are found nearby.
Status explain_unless_participant(const std::filesystem::path& given);

}  // namespace ddssec::secured
