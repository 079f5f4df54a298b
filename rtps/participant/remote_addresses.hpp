// Chooses which of a remote participant's addresses are used. See ProvenHosts.
#pragma once

#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Adopts the addresses that the participant signed in a handshake that has finished; if a list is
/// empty, the announced ones count. From now on only those at proven hosts are used. If there are
/// none, its builtin endpoints can still be reached at the signed addresses, within
/// AmplificationLimit. Returns true if it signed any address that messages can be sent to.
bool adopt_signed_addresses(ParticipantCore& core, RemoteParticipant& remote,
                            LocatorList metatraffic, LocatorList user);

/// Notes that a new message under the participant's keys came from the host. Returns true if the
/// host was not proven before. The addresses that are used for the participant may then have
/// changed.
bool prove_host(const ParticipantCore& core, RemoteParticipant& remote, const Locator& host);

/// Call it if the participant does not answer at its hosts. If it signed an address at none
/// of them, they are doubted from now on: an attacker may have sent a copy of a handshake message
/// from there. So its signed addresses are used, within AmplificationLimit, until a host is proven.
/// If called again, it returns to the doubted hosts, because the participant may be behind a
/// router. Returns false if nothing changed.
bool switch_doubted_hosts(const ParticipantCore& core, RemoteParticipant& remote);

/// Chooses the participant's addresses again, after the addresses of this machine have changed.
/// Returns true if the choice is different.
bool choose_addresses_of(const ParticipantCore& core, RemoteParticipant& remote);

/// True unless the participant signed its addresses and none of them is proven.
bool has_proven_address(const ParticipantCore& core, const RemoteParticipant& remote);

/// Returns the addresses that are used for an endpoint: its own ones at hosts of its participant,
/// or else those of its participant. Raises an event once if none of its own ones is at such a
/// host.
/// If anyone can have announced the endpoint, the addresses of its participant are used in
/// addition. The number of its own addresses that its participant does not have is then limited
/// (ClearAddresses). Further ones are left out, and an event is raised once.
LocatorList addresses_of(ParticipantCore& core, RemoteParticipant& remote,
                         const EndpointData& endpoint);

}  // namespace ddssec::rtps
