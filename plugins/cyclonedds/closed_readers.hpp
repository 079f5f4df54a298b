// Closes some builtin readers of Cyclone's core, so that they match no remote writer.
//
// The core trusts unprotected announcements in the name of an authenticated participant under every
// kind of protection. With one datagram, an attacker could remove the participant's endpoints, move
// them to another address or invent some, or crash the process with a type lookup.
//
// The core matches a protected endpoint only with one whose keys it has. So access control reports
// these readers as protected although there are no keys for them, and the core drops everything
// from any writer of their topics.
//
// The unprotected reader of liveliness is not closed: version 0.10.2 of the core asserts liveliness
// by it alone, under every liveliness_protection_kind.
#pragma once

#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// The choice for the readers of type lookup (DDS-XTypes 7.6.3.3).
enum class TypeLookup : bool { open, closed };

/// True if that builtin reader must be closed. The readers of unprotected endpoint announcements
/// stay open only if governance leaves the discovery of some topic unprotected: honest peers
/// announce such endpoints to the same readers.
bool is_closed(const spi::EndpointRequest& reader,
               const spi::ParticipantSecurityAttributes& participant, TypeLookup lookup);

}  // namespace ddssec::cyclonedds
