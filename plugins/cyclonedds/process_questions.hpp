// Questions of one ddssec library to the other two in the process. Each is looked up late, because
// the host loads the other library later. A stock library gives no answer.
#pragma once

#include <optional>
#include <string>

#include "plugins/cyclonedds/governance_facts.hpp"
#include "plugins/cyclonedds/handshake_watch.hpp"
#include "plugins/spi/symmetric_cipher.hpp"

namespace ddssec::cyclonedds {

/// True if the process uses libddssec_cryptography.
bool has_our_cryptography();

/// True if the process uses libddssec_authentication.
bool has_our_authentication();

/// Returns the signed permissions of a local participant, if they were renewed more than `known`
/// times; `known` is then set to that number. Empty without libddssec_access_control.
std::optional<std::string> renewed_permissions(spi::IdentityHandle local, std::uint64_t& known);

/// Returns the number of times that renewed permissions changed the rights of an endpoint of a
/// local participant so that its sessions must end. 0 without libddssec_access_control.
std::uint64_t rights_changed(spi::IdentityHandle local);

/// Makes libddssec_authentication end now the sessions of which the answers to its questions say
/// that they must end. Does nothing without that library.
void end_sessions_now() noexcept;

/// Returns the ciphers that libddssec_cryptography in this process can decrypt; the standard's
/// ciphers if it is not loaded.
spi::CipherMask ciphers_of_process();

/// Returns the questions; empty functions without libddssec_cryptography.
HandshakeWatch::Questions questions_to_cryptography();

/// Notes that a reader of this process may have ended: libddssec_cryptography announces that to the
/// peers (reader_ends.hpp). Without this library nothing happens.
void look_for_ended_readers() noexcept;

/// Cuts off a local participant whose certificate or permissions have expired. Cyclone's core would
/// delete the participant although the application still uses its entities, and the process would
/// crash at the next call that needs it. So the core is not informed, and the other ddssec plugins
/// refuse the participant everything, as far as they are loaded.
///
/// The core is informed if the process has other participants in the domain. Peers keep discovering
/// a participant that is announced, and the messages that they send when they give it up would end
/// the session for all participants of the process.
void cut_off_cryptography(spi::IdentityHandle local);
void cut_off_access_control(spi::IdentityHandle local);

/// Makes access control drop the permissions of a remote participant that the host has forgotten.
void return_permissions_of(spi::IdentityHandle peer) noexcept;

/// True if the fact holds. False without libddssec_access_control.
bool holds(GovernanceFact fact, spi::IdentityHandle local);
inline bool admits_unauthenticated(spi::IdentityHandle local) {
  return holds(GovernanceFact::allows_unauthenticated, local);
}

}  // namespace ddssec::cyclonedds
