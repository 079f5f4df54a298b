// The attacker on the path: it sees every datagram, and decides what happens to it. It has no key.
#pragma once

#include "tests/sim/invariants.hpp"
#include "tests/sim/mangle.hpp"
#include "tests/sim/network.hpp"

namespace ddssec::rtps::sim {

/// How often it makes each attack: in a thousand datagrams, or in a thousand steps for attacks that
/// it adds.
struct Temper {
  unsigned drop = 0, duplicate = 0, delay = 0, mangle = 0, cut_short = 0, splice = 0;  // datagrams
  unsigned bridge = 0;    ///< exchanges the domain tags
  unsigned muffle = 0;    ///< drops handshake messages
  unsigned silence = 0;   ///< cuts all connections of a node for some time
  unsigned replay = 0;    ///< a burst of recorded datagrams
  unsigned forge = 0;     ///< a burst of forgeries of one kind
  unsigned announce = 0;  ///< a burst of Forger::announcements
  unsigned crowd = 0;     ///< a burst of Forger::crowd
  unsigned ambush = 0;    ///< a burst of Ambush
};

class Outsider {
 public:
  Outsider(const Ledger& ledger, const Invariants& invariants, Network& network, Dice dice)
      : ledger_(ledger),
        invariants_(invariants),
        network_(network),
        dice_(dice),
        further_(dice.fork("further")),
        ambush_(dice.fork("ambush")) {}

  /// Decides what happens to a datagram.
  void carry(Datagram datagram, MonotonicTime now);
  /// Makes one step of its own. `nodes` is the number of addresses.
  void act(MonotonicTime now, std::size_t nodes);
  /// Changes the temper. From now on no participant is cut off any longer.
  void behave(const Temper& temper) {
    temper_ = temper;
    silenced_.clear();
  }
  void silence(const Locator& whom, MonotonicTime until) { silenced_[whom] = until; }
  /// Puts a datagram of its own on the network.
  void inject(Datagram datagram, MonotonicTime now);
  const std::vector<Datagram>& recorded() const { return recorded_; }
  std::uint64_t sent() const { return sent_; }

 private:
  static constexpr std::size_t kMaxRecorded = 3000;

  void record(const Datagram& datagram);
  bool is_silenced(const Datagram& datagram, MonotonicTime now) const;
  MonotonicTime arrival(MonotonicTime now);
  void replay(MonotonicTime now, std::size_t nodes);
  void forge(MonotonicTime now, std::size_t nodes);
  void announce(MonotonicTime now, std::size_t nodes);
  void crowd(MonotonicTime now);
  void ambush(MonotonicTime now);
  Bytes spliced(const Bytes& octets);
  std::vector<GuidPrefix> names() const;

  const Ledger& ledger_;
  const Invariants& invariants_;
  Network& network_;
  Dice dice_;
  Dice further_, ambush_;  ///< for kinds of attacks that were added later
  Temper temper_;
  std::vector<Datagram> recorded_;
  std::map<Locator, MonotonicTime> silenced_;
  std::uint64_t sent_ = 0;
};

}  // namespace ddssec::rtps::sim
