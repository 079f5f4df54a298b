// What both sides signed: the six values of one handshake (DDS-Security 9.3.2.5.2, 9.3.2.5.3).
#pragma once

#include "base/hash.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::authentication {

/// Filled in the order in which the values become known. dh1 and dh2 are the octets as transmitted.
struct Transcript {
  Sha256Digest hash_c1{};
  spi::Challenge challenge1{};
  Bytes dh1 = {};
  Sha256Digest hash_c2{};
  spi::Challenge challenge2{};
  Bytes dh2 = {};

  /// What the replier signs.
  Bytes reply_input() const;
  /// What the initiator signs.
  Bytes final_input() const;
};

}  // namespace ddssec::authentication
