// The cast, the network, the attackers and the time of a simulation.
#pragma once

#include "tests/sim/node.hpp"
#include "tests/sim/outsider.hpp"

namespace ddssec::rtps::sim {

class World final : private Wire {
 public:
  static constexpr MonotonicTime kStep = milliseconds(10);

  /// For `has_interfaces` see Surroundings.
  World(const Protection& protection, std::span<const Subject> cast, Dice dice,
        bool has_interfaces);

  /// Makes the outsider take the network, or the network fair.
  void set_hostile(bool hostile);
  /// Checks that no honest participant knows one that died long ago.
  void check_dead();
  /// Lets kStep pass: datagrams and events that are due arrive and happen.
  void step();

  MonotonicTime now() const { return now_; }
  const std::optional<Violation>& violation() const { return invariants_.violation(); }
  Invariants& invariants() { return invariants_; }
  Outsider& outsider() { return outsider_; }
  Malice& malice() { return malice_; }
  const Ledger& ledger() const { return ledger_; }
  std::vector<std::unique_ptr<Node>>& nodes() { return nodes_; }
  void start(Node& node);
  /// Returns a fingerprint of everything that was sent, to see that a seed repeats a run bit by
  /// bit.
  std::uint64_t fingerprint() const { return fingerprint_; }
  std::uint64_t delivered() const { return delivered_; }

 private:
  void carry(const Subject& from, Datagram datagram, bool for_honest) override;
  void deliver(const Datagram& datagram);
  /// Returns nullptr if no node is there.
  Node* node_at(const Locator& address) const;
  /// Makes an insider forge with a key that it was given.
  void use_stolen_key();
  /// Returns an endpoint of any honest participant that runs.
  Guid endpoint_to_claim(bool writes);
  /// Makes an insider send keys of its own in the name of the key's owner.
  void send_false_keys();
  /// True if the cast has siblings, which come last.
  bool has_siblings() const { return nodes_.back()->is_sibling(); }
  void check_tables();
  void check_shares(const Node& node);
  void note(BytesView octets);

  /// The octets that arrived at a node, and those that it sent to addresses where no participant
  /// is.
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
