// Peers whose permissions the renewal list extends.
#pragma once

#include "base/plugin_services.hpp"
#include "plugins/access_control/handle_table.hpp"

namespace ddssec::access_control {

/// Extends the permissions of each peer in `entries` by the renewal list of the local participant
/// that knows the peer (PermissionsHolder::follow_list). Before a peer's permissions end, the list
/// is read once more. Raises the events about extensions and about unusable lists.
void follow_renewal_lists(const Entries& entries, DocumentCache& documents,
                          const PluginServices& services);

}  // namespace ddssec::access_control
