// An outsider's forgeries against participants that have just begun: other endpoints of theirs
// before the protected announcements arrive, other addresses between handshake and keys.
#pragma once

#include "tests/sim/dice.hpp"
#include "tests/sim/invariants.hpp"
#include "tests/sim/network.hpp"

namespace ddssec::rtps::sim {

class Ambush {
 public:
  /// How long a participant is attacked after its start.
  static constexpr MonotonicTime kYouth = seconds(5);

  Ambush(const Ledger& ledger, const Invariants& invariants, std::span<const Datagram> recorded,
         Dice& dice)
      : ledger_(ledger), invariants_(invariants), recorded_(recorded), dice_(dice) {}

  /// Returns clear announcements in the name of an honest participant. Empty if none is that young,
  /// or if it was not heard in the clear.
  Bytes operator()(MonotonicTime now);

 private:
  std::vector<GuidPrefix> young(MonotonicTime now) const;
  Bytes endpoints_of(const GuidPrefix& victim);
  Bytes addresses_of(const GuidPrefix& victim);

  const Ledger& ledger_;
  const Invariants& invariants_;
  std::span<const Datagram> recorded_;
  Dice& dice_;
};

}  // namespace ddssec::rtps::sim
