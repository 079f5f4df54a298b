// What an insider can send with the keys that it was given: as their owners would protect it.
#pragma once

#include "plugins/cryptography/send_key.hpp"
#include "tests/sim/forgeries.hpp"

namespace ddssec::rtps::sim {

class StolenKeys {
 public:
  StolenKeys(Forger& forger, std::span<const Datagram> recorded, Dice& dice)
      : forger_(forger), recorded_(recorded), dice_(dice) {}

  /// A sample of its owner's, protected by what each receiver of `token` holds. Empty: it has no
  /// key, or nothing protected by it was heard.
  Bytes sample(const spi::Token& token);
  /// A message of the key exchange between its owner and `to`, protected by that key: keys of the
  /// attacker's under each number that may be the next one, or a HEARTBEAT or GAP beyond them.
  Bytes key_exchange(const spi::Token& token, const GuidPrefix& to);

 private:
  /// A datagram of the key's owner.
  const Datagram* protected_by(const KeyId& sender);
  /// Where that sender may go on after a datagram of its own.
  cryptography::SendStart after(BytesView datagram, const KeyId& sender);
  /// Whose MACs a datagram bears.
  static std::vector<KeyId> receivers_of(BytesView datagram);
  /// Key tokens that a participant, or one of its writers, gives to `to`, under many numbers.
  std::vector<Bytes> tokens(const GuidPrefix& from, const GuidPrefix& to);
  /// Makes the volatile reader skip all that comes.
  Bytes horizon();

  Forger& forger_;
  std::span<const Datagram> recorded_;
  Dice& dice_;
};

}  // namespace ddssec::rtps::sim
