// The cast, the network and the attackers together, and time.
#pragma once

#include "tests/sim/node.hpp"
#include "tests/sim/outsider.hpp"

namespace ddssec::rtps::sim {

class World final : private Wire {
 public:
  static constexpr MonotonicTime kStep = milliseconds(10);

  /// `has_interfaces`: see Surroundings.
  World(const Protection& protection, std::span<const Subject> cast, Dice dice,
        bool has_interfaces);

  /// The outsider takes the network, or the network is fair.
  void set_hostile(bool hostile);
  /// No honest participant knows one that died long ago.
  void check_dead();
  /// kStep passes: what is due arrives and happens.
  void step();

  MonotonicTime now() const { return now_; }
  const std::optional<Violation>& violation() const { return invariants_.violation(); }
  Invariants& invariants() { return invariants_; }
  Outsider& outsider() { return outsider_; }
  Malice& malice() { return malice_; }
  const Ledger& ledger() const { return ledger_; }
  std::vector<std::unique_ptr<Node>>& nodes() { return nodes_; }
  void start(Node& node);
  /// Of everything that was sent, to see that a seed repeats a run bit by bit.
  std::uint64_t fingerprint() const { return fingerprint_; }
  std::uint64_t delivered() const { return delivered_; }

 private:
  void carry(const Subject& from, Datagram datagram, bool for_honest) override;
  void deliver(const Datagram& datagram);
  /// nullptr: none is there.
  Node* node_at(const Locator& address) const;
  /// An insider forges with a key that it was given.
  void use_stolen_key();
  /// Of any honest participant that runs.
  Guid endpoint_to_claim(bool writes);
  /// It sends keys of its own in the name of the key's owner.
  void send_false_keys();
  /// They come last.
  bool has_siblings() const { return nodes_.back()->is_sibling(); }
  void check_tables();
  void check_shares(const Node& node);
  void note(BytesView octets);

  /// Octets that arrived at a node, and that it sent to addresses where nobody is.
  struct Flow {
    std::size_t in = 0, lost = 0;
  };

  MonotonicTime now_ = seconds(1);
  Ledger ledger_;
  Invariants invariants_;
  Network network_;
  Outsider outsider_;
  Malice malice_;
  const Surroundings around_;
  const Protection& protection_;
  Dice further_;  ///< for kinds of attacks that were added later
  std::vector<std::unique_ptr<Node>> nodes_;
  std::map<Locator, Node*> by_address_;
  bool hostile_ = false;
  std::uint64_t fingerprint_ = 0;
  std::uint64_t delivered_ = 0;
  std::map<Locator, Flow> flows_;
};

}  // namespace ddssec::rtps::sim
