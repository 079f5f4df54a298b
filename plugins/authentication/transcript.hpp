// The signed content of a handshake: six values (DDS-Security 1.2, clauses 10.3.2.5.2
// and 10.3.2.5.3).
#pragma once

#include "base/hash.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::authentication {

/// The values, in the order in which they become known. dh1 and dh2 are the octets as transmitted.
struct Transcript {
  Sha256Digest hash_c1{};
  spi::Challenge challenge1{};
  Bytes dh1 = {};
  Sha256Digest hash_c2{};
  spi::Challenge challenge2{};
  Bytes dh2 = {};

  /// Returns the octets that the replier signs.
  Bytes reply_input() const;
  /// Returns the octets that the initiator signs.
  Bytes final_input() const;
};

}  // namespace ddssec::authentication
