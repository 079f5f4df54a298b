// Checks whether the three security plugins start, without a participant and without a socket.
#pragma once

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::secured {

/// Returns what an embedded participant can do for access control. Its plugins are made with this.
access_control::AccessControlOptions embedded_access_control_options();

/// Makes the three plugins for a host with these options, and authenticates and authorizes a local
/// participant with the properties, as of the calendar time `now`. Success if the participant would
/// start. Raises no events. Errors: those of rtps::OwnSecurity::create.
Status check_start(spi::PropertyList properties, const access_control::AccessControlOptions& host,
                   DomainId domain, WallTime now);

}  // namespace ddssec::secured
