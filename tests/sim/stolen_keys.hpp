// Messages that an insider can send with the keys that it was given, protected as their owners
// would protect them.
#pragma once

#include "plugins/cryptography/send_key.hpp"
#include "tests/sim/forgeries.hpp"

namespace ddssec::rtps::sim {

class StolenKeys {
 public:
  StolenKeys(Forger& forger, std::span<const Datagram> recorded, Dice& dice)
      : forger_(forger), recorded_(recorded), dice_(dice) {}

  /// Returns a sample of the key's owner, protected by what each receiver of `token` holds. Empty
  /// if the owner has no key, or if nothing protected by it was heard.
  Bytes sample(const spi::Token& token);
  /// Returns a message of the key exchange between the key's owner and `to`, protected by that key:
  /// keys of the attacker's under each number that may be the next one, or a HEARTBEAT or GAP
  /// beyond them.
  Bytes key_exchange(const spi::Token& token, const GuidPrefix& to);

 private:
  /// Returns a datagram of the key's owner.
  const Datagram* protected_by(const KeyId& sender);
  /// Returns the place where that sender may go on after a datagram of its own.
  cryptography::SendStart after(BytesView datagram, const KeyId& sender);
  /// Returns the keys whose MACs a datagram has.
  static std::vector<KeyId> receivers_of(BytesView datagram);
  /// Returns key tokens that a participant, or one of its writers, gives to `to`, under many
  /// numbers.
  std::vector<Bytes> tokens(const GuidPrefix& from, const GuidPrefix& to);
  /// Returns a submessage that makes the volatile reader skip everything that arrives.
  Bytes horizon();

  Forger& forger_;
  std::span<const Datagram> recorded_;
  Dice& dice_;
};

}  // namespace ddssec::rtps::sim
