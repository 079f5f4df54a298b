#include "tests/sim/world.hpp"

namespace ddssec::rtps::sim {

World::World(const Protection& protection, std::span<const Subject> cast, Dice dice)
    : invariants_(ledger_, protection, now_),
      outsider_(ledger_, invariants_, network_, dice.fork("outsider")),
      malice_{.dice = dice.fork("insider")},
      around_{protection, now_, ledger_, invariants_, malice_, *this} {
  for (const auto& subject : cast)
    nodes_.push_back(std::make_unique<Node>(
        around_, subject, nodes_.size(), dice.fork(subject.name + std::to_string(nodes_.size()))));
}

void World::start(Node& node) {
  GuidPrefix name;
  for (const auto& other : nodes_)
    if (other->is_running() && other->is_honest()) name = other->prefix();
  node.start(name);
  if (node.is_running()) malice_.names.push_back(node.prefix());
}

void World::set_hostile(bool hostile) {
  hostile_ = hostile;
  if (hostile) return;
  outsider_.behave({});
  malice_.tampers = 0;
  network_.lose_all();
}

void World::carry(const Subject& from, Datagram datagram) {
  (void)from;
  note(datagram.octets);
  if (hostile_)
    outsider_.carry(std::move(datagram), now_);
  else
    network_.post(std::move(datagram), now_ + Network::kLatency);
}

void World::deliver(const Datagram& datagram) {
  for (const auto& node : nodes_) {
    const bool own = node->address() == datagram.from && datagram.to == kGroup;
    if (own || (datagram.to != kGroup && datagram.to != node->address())) continue;
    ++delivered_;
    node->receive(datagram);
  }
}

// FNV-1a.
void World::note(BytesView octets) {
  for (const auto octet : octets) fingerprint_ = (fingerprint_ ^ octet) * 0x100000001b3;
}

void World::step() {
  now_ += kStep;
  if (hostile_) outsider_.act(now_, nodes_.size());
  for (const auto& datagram : network_.arrived(now_)) deliver(datagram);
  for (const auto& node : nodes_) node->advance(kStep);
}

}  // namespace ddssec::rtps::sim
