// What one of our libraries asks the other two in the process. Each is looked up late, as
// the host loads it after us; a stock library in its place gives no answer.
#pragma once

#include "plugins/cyclonedds/governance_facts.hpp"
#include "plugins/cyclonedds/handshake_watch.hpp"
#include "plugins/spi/symmetric_cipher.hpp"

namespace ddssec::cyclonedds {

/// Is the cryptography of this process ours?
bool has_our_cryptography();

/// What our cryptography in this process can decrypt; the standard's ciphers without ours.
spi::CipherMask ciphers_of_process();

/// Empty functions without ours.
HandshakeWatch::Questions questions_to_cryptography();

/// A reader of this process may have ended: our cryptography says so to the peers
/// (reader_ends.hpp). Nothing without ours.
void look_for_ended_readers() noexcept;

/// The certificate or the permissions of a local participant have ended. Cyclone's core would delete
/// the participant beneath the application's entities, and the process would end at the next call
/// that needs it. So the core is not told, and our other plugins refuse it everything, as far as
/// they are ours. Where the process has others in the domain, it is told: peers go on meeting a
/// participant that is announced, and what they say when they give it up ends them for all
/// participants of the process.
void cut_off_cryptography(spi::IdentityHandle local);
void cut_off_access_control(spi::IdentityHandle local);

/// Without our access control nothing is known.
bool holds(GovernanceFact fact, spi::IdentityHandle local);

}  // namespace ddssec::cyclonedds
