// Peers whose permissions the renewal list has in a later form.
#pragma once

#include "base/event.hpp"
#include "plugins/access_control/handle_table.hpp"

namespace ddssec::access_control {

/// The peers among these are judged by the later permissions of their participants' lists, as
/// PermissionsHolder::follow_list has it. If one of them ends, the lists are read once more before.
/// Raises the events about both.
void follow_renewal_lists(const Entries& entries, DocumentCache& documents,
                          const Environment& environment);

}  // namespace ddssec::access_control
