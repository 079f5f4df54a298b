// The domain tag of the local participant, which Cyclone's core gives no plugin before a handshake.
#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::cyclonedds {

/// Success if the core's data about the local participant (c.pdata) has no domain tag. With one,
/// the rules for the empty tag would be in force, because access control was asked before the tag
/// could be known. Error: domain_not_covered.
Status check_no_domain_tag(BytesView participant_data);

}  // namespace ddssec::cyclonedds
