#include "tests/sim/world.hpp"

#include "tests/sim/stolen_keys.hpp"

namespace ddssec::rtps::sim {

World::World(const Protection& protection, std::span<const Subject> cast, Dice dice,
             bool has_interfaces)
    : invariants_(ledger_, protection, now_),
      outsider_(ledger_, invariants_, network_, dice.fork("outsider")),
      malice_{.dice = dice.fork("insider"), .further = dice.fork("claims")},
      around_{protection, now_, ledger_, invariants_, malice_, *this, has_interfaces},
      protection_(protection),
      further_(dice.fork("further")) {
  malice_.submessages = [this] {
    return Forger(ledger_, invariants_, outsider_.recorded(), malice_.dice)
        .in_the_name_of_another();
  };
  malice_.endpoint = [this](bool writes) { return endpoint_to_claim(writes); };
  for (const auto& subject : cast)
    nodes_.push_back(std::make_unique<Node>(
        around_, subject, nodes_.size(), dice.fork(subject.name + std::to_string(nodes_.size()))));
  for (const auto& node : nodes_) by_address_[node->address()] = node.get();
  invariants_.expect_siblings(static_cast<std::size_t>(
      std::ranges::count_if(nodes_, [](const auto& node) { return node->is_sibling(); })));
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
  malice_.tampers = malice_.false_keys = malice_.claims = 0;
  network_.lose_all();
}

void World::carry(const Subject& from, Datagram datagram, bool for_honest) {
  note(datagram.octets);
  const auto& to = datagram.to;
  const bool somewhere = to == kGroup || node_at(to) != nullptr;
  if (for_honest && !somewhere)
    invariants_.fail(invariant::kAstray, from.name + " sent a sample to " + to_string(to));
  if (around_.has_interfaces && from.is_honest() && to.is_loopback())
    invariants_.fail(invariant::kAstray, from.name + " sent to a service of its own machine");
  auto& flow = flows_[datagram.from];
  flow.lost += somewhere ? 0 : datagram.octets.size();
  if (from.is_honest() && flow.lost > 3 * flow.in + Invariants::kMaxReflected)
    invariants_.fail(invariant::kReflection, from.name + " sent " + std::to_string(flow.lost) +
                                                 " octets, and got " + std::to_string(flow.in));
  if (hostile_)
    outsider_.carry(std::move(datagram), now_);
  else
    network_.post(std::move(datagram), now_ + Network::kLatency);
}

Node* World::node_at(const Locator& address) const {
  const auto at = by_address_.find(address);
  return at == by_address_.end() ? nullptr : at->second;
}

// Delivers a datagram. Those among siblings are left out, because nothing depends on them.
void World::deliver(const Datagram& datagram) {
  const auto* sender = node_at(datagram.from);
  const auto deliver_to = [&](Node& node) {
    if (sender != nullptr && sender->is_sibling() && node.is_sibling()) return;
    ++delivered_;
    flows_[node.address()].in += datagram.octets.size();
    node.receive(datagram);
  };
  if (datagram.to != kGroup) {
    if (auto* node = node_at(datagram.to)) deliver_to(*node);
    return;
  }
  for (const auto& node : nodes_)
    if (node.get() != sender) deliver_to(*node);
}

// Adds octets to the fingerprint (FNV-1a).
void World::note(BytesView octets) {
  for (const auto octet : octets) fingerprint_ = (fingerprint_ ^ octet) * 0x100000001b3;
}

void World::step() {
  now_ += kStep;
  if (hostile_) outsider_.act(now_, nodes_.size());
  if (hostile_ && malice_.dice.chance(malice_.tampers)) use_stolen_key();
  if (hostile_ && further_.chance(malice_.false_keys)) send_false_keys();
  for (const auto& datagram : network_.arrived(now_)) deliver(datagram);
  for (const auto& node : nodes_) node->advance(kStep);
  check_tables();
}

Guid World::endpoint_to_claim(bool writes) {
  std::vector<Guid> out;
  for (const auto& node : nodes_)
    if (node->subject().role == Role::honest && node->is_running())
      for (const auto& endpoint : node->endpoints())
        if (endpoint->end().writes == writes) out.push_back(endpoint->end().guid);
  return out.empty() ? Guid{} : malice_.further.of(out);
}

// Without origin authentication a reader can also write, which is the standard's design. So there
// is nothing to check then.
void World::use_stolen_key() {
  const auto& tokens = malice_.stolen.all;
  if (!protection_.tells_readers_from_writers || tokens.empty() || outsider_.recorded().empty())
    return;
  Forger forger(ledger_, invariants_, outsider_.recorded(), malice_.dice);
  StolenKeys keys(forger, outsider_.recorded(), malice_.dice);
  auto octets = keys.sample(malice_.dice.of(tokens));
  const auto at = malice_.dice.below(nodes_.size() + 3);
  if (!octets.empty())
    outsider_.inject({address_of(at), address_of(malice_.dice.below(nodes_.size())), octets}, now_);
}

void World::send_false_keys() {
  const auto& tokens = malice_.stolen.all;
  const auto& victim = *further_.of(nodes_);
  if (tokens.empty() || outsider_.recorded().empty() || !victim.is_running()) return;
  Forger forger(ledger_, invariants_, outsider_.recorded(), further_);
  StolenKeys keys(forger, outsider_.recorded(), further_);
  // One of the latest tokens is taken, because their owners still use them.
  const auto latest = std::min<std::size_t>(tokens.size(), 60);
  Bytes octets;
  for (int attempt = 0; attempt < 8 && octets.empty(); ++attempt)
    octets = keys.key_exchange(tokens[tokens.size() - 1 - further_.below(latest)], victim.prefix());
  const auto from = address_of(further_.below(nodes_.size() + 3));
  if (!octets.empty()) outsider_.inject({from, victim.address(), std::move(octets)}, now_);
}

void World::check_shares(const Node& node) {
  std::map<std::string_view, std::size_t> of_certificate;
  for (const auto& [prefix, remote] : node.participant().remote_participants().all()) {
    const auto* life = ledger_.life(prefix);
    if (life == nullptr || !node.participant().is_authenticated(prefix)) continue;
    const auto taken = ++of_certificate[life->subject->name];
    if (taken > Handshakes::kMaxAuthenticated / 2)
      invariants_.fail(invariant::kShare, life->subject->name + " has " + std::to_string(taken) +
                                              " places at " + node.subject().name);
  }
}

void World::check_tables() {
  for (const auto& node : nodes_) {
    if (!node->is_honest() || !node->is_running()) continue;
    const auto& known = node->participant().remote_participants().all();
    const auto& name = node->subject().name;
    if (has_siblings()) check_shares(*node);
    if (known.size() > RemoteParticipants::kMaxParticipants)
      invariants_.fail(invariant::kMemory,
                       name + " knows " + std::to_string(known.size()) + " participants");
    if (!protection_.hides_strangers) continue;
    for (const auto& [prefix, remote] : known)
      if (ledger_.life(prefix) == nullptr)
        invariants_.fail(invariant::kForged,
                         name + " knows " + prefix.to_string() + ", which has no pre-shared key");
  }
}

void World::check_dead() {
  for (const auto& node : nodes_) {
    if (!node->is_honest()) continue;
    for (const auto& [prefix, life] : ledger_.lives())
      if (life.died != kNever && now_ - life.died > Invariants::kMaxMemory &&
          node->participant().is_authenticated(prefix))
        invariants_.fail(invariant::kGone, node->subject().name + " still knows " +
                                               prefix.to_string() + " of " + life.subject->name);
  }
}

}  // namespace ddssec::rtps::sim
