// Checks that a folder belongs to a participant. If it does not, the error suggests what may have
// been meant.
#pragma once

#include <filesystem>

#include "base/result.hpp"

namespace ddssec::secured {

/// =
Status check_is_participant(const std::filesystem::path& given);

}  // namespace ddssec::secured
