// Whether a folder is a participant's, and what a person may have meant if it is not.
#pragma once

#include <filesystem>

#include "base/result.hpp"

namespace ddssec::secured {

/// Success if `given` is a folder with something of a participant, or none of the others that are
/// told apart here. Errors: file_not_found (nothing is there; it is a CA's folder, or one that
/// holds participants), file_unreadable (no folder). They name participants nearby.
Status check_is_participant(const std::filesystem::path& given);

}  // namespace ddssec::secured
