// The kind of submessage that a fuzz target is for.
#pragma once

#include <optional>

#include "wire/submessage.hpp"

namespace ddssec::fuzz {

/// Returns the kind; none for a target of whole messages.
std::optional<rtps::SubmessageId> kind();

}  // namespace ddssec::fuzz
