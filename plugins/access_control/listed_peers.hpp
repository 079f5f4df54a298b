// Peers whose permissions the renewal list extends.
#pragma once

#include "base/event.hpp"
#include "plugins/access_control/handle_table.hpp"

namespace ddssec::access_control {

/// The permissions of the peers among these are extended by the lists of their participants, as
/// PermissionsHolder::follow_list has it. If one of them ends, the lists are read once more before.
/// Raises the events about both.
void follow_renewal_lists(const Entries& entries, DocumentCache& documents,
                          const Environment& environment);

}  // namespace ddssec::access_control
