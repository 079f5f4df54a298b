// Which builtin readers of Cyclone's core match no remote writer. The core believes clear
// announcements in the name of an authenticated participant under every kind of protection: a
// stranger could remove its endpoints, move them to another address, or invent some, with one
// datagram, and end the process with a lookup of a type. The core matches an endpoint that is
// protected only with one whose keys it got. So access control calls these readers protected, and
// there are no keys for them: the core drops what comes from any writer of theirs.
// Not the unprotected reader of liveliness: version 0.10.2 of the core asserts liveliness by that
// one alone, under every liveliness_protection_kind.
#pragma once

#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// What becomes of the readers of type lookup (DDS-XTypes 7.6.3.3).
enum class TypeLookup : bool { stays_open, is_closed };

/// Clear announcements of endpoints count only where governance leaves those of some topic
/// unprotected: honest peers announce its endpoints to the same readers.
bool is_closed(const spi::EndpointRequest& reader,
               const spi::ParticipantSecurityAttributes& participant, TypeLookup lookup);

}  // namespace ddssec::cyclonedds
