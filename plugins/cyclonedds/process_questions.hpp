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

/// Without our access control nothing is known.
bool holds(GovernanceFact fact, spi::IdentityHandle local);

}  // namespace ddssec::cyclonedds
