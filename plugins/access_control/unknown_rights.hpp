// Endpoints of the local participant that its peers do not match, because they know only former
// permissions.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "plugins/access_control/access_decisions.hpp"
#include "plugins/access_control/handle_table.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

/// Answers AccessControl::find_unknown_right for the local participant `own` with these peers. If
/// there is such an endpoint, all peers that know only former permissions are noted
/// (PermissionsHolder::note_must_end), because their sessions will end. A peer that was noted
/// before does not count.
std::optional<std::size_t> find_unknown_right(
    const AccessDecisions& decisions, const PermissionsHolder& own,
    const std::vector<Holder>& peers, std::span<const spi::AccessControl::OwnEndpoint> endpoints);

}  // namespace ddssec::access_control
