#include "tests/sim/outsider.hpp"

#include "tests/sim/ambush.hpp"
#include "tests/sim/forgeries.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps::sim {

namespace {

bool holds(BytesView octets, BytesView what) { return !std::ranges::search(octets, what).empty(); }

// Moves a datagram from one domain to the other.
void bridge(Bytes& octets) {
  const auto north = as_bytes(kTags[0]), south = as_bytes(kTags[1]);
  const bool northern = holds(octets, north);
  exchange(octets, northern ? north : south, northern ? south : north);
}

}  // namespace

// Records a datagram. The first ones stay, because the handshakes are among them. Of the others a
// random part stays.
void Outsider::record(const Datagram& datagram) {
  if (recorded_.size() < kMaxRecorded)
    recorded_.push_back(datagram);
  else
    recorded_[kMaxRecorded / 4 + dice_.below(kMaxRecorded * 3 / 4)] = datagram;
}

bool Outsider::is_silenced(const Datagram& datagram, MonotonicTime now) const {
  return std::ranges::any_of(silenced_, [&](const auto& one) {
    return now < one.second && (one.first == datagram.from || one.first == datagram.to);
  });
}

MonotonicTime Outsider::arrival(MonotonicTime now) {
  const bool late = dice_.chance(temper_.delay);
  return now + Network::kLatency + (late ? milliseconds(dice_.below(2000)) : milliseconds(0));
}

void Outsider::carry(Datagram datagram, MonotonicTime now) {
  if (dice_.chance(temper_.drop) || is_silenced(datagram, now)) return;
  if (dice_.chance(temper_.muffle) && holds(datagram.octets, kStatelessMessageWriter.view()))
    return;
  record(datagram);
  if (dice_.chance(temper_.bridge)) bridge(datagram.octets);
  if (dice_.chance(temper_.duplicate)) network_.post(datagram, arrival(now));
  if (dice_.chance(temper_.splice)) {
    auto other = datagram;
    other.octets = spliced(datagram.octets);
    inject(std::move(other), now);
  }
  if (dice_.chance(temper_.mangle)) {
    auto other = datagram;
    mangle(other.octets, dice_, names());
    if (dice_.chance(500)) return inject(std::move(other), now);
    inject(std::move(other), now);
  }
  if (dice_.chance(temper_.cut_short)) datagram.octets.resize(dice_.below(datagram.octets.size()));
  const auto due = arrival(now);
  network_.post(std::move(datagram), due);
}

void Outsider::inject(Datagram datagram, MonotonicTime now) {
  ++sent_;
  network_.post(std::move(datagram), now + Network::kLatency);
}

void Outsider::act(MonotonicTime now, std::size_t nodes) {
  if (recorded_.empty()) return;
  if (dice_.chance(temper_.silence))
    silenced_[address_of(dice_.below(nodes))] = now + milliseconds(dice_.below(120'000));
  if (dice_.chance(temper_.replay)) replay(now, nodes);
  if (dice_.chance(temper_.forge)) forge(now, nodes);
  if (further_.chance(temper_.announce)) announce(now, nodes);
  if (temper_.crowd > 0 && further_.chance(temper_.crowd)) crowd(now);
  if (temper_.ambush > 0 && ambush_.chance(temper_.ambush)) ambush(now);
}

// Replays datagrams to the addresses to which they were sent, or to any, and from the addresses
// from which they came, or from any.
void Outsider::replay(MonotonicTime now, std::size_t nodes) {
  for (auto count = 1 + dice_.below(30); count > 0; --count) {
    auto datagram = dice_.of(recorded_);
    if (dice_.chance(200)) datagram.to = address_of(dice_.below(nodes));
    if (dice_.chance(200)) datagram.from = address_of(dice_.below(nodes + 3));
    inject(std::move(datagram), now);
  }
}

void Outsider::forge(MonotonicTime now, std::size_t nodes) {
  const auto victim = address_of(dice_.below(nodes));
  Forger forger(ledger_, invariants_, recorded_, dice_);
  for (auto& [octets, from] : forger.burst(nodes)) {
    const bool to_all = dice_.chance(100);
    inject({from, to_all ? kGroup : victim, std::move(octets)}, now);
  }
}

// Sends announcements, but none to the machine from which it claims to come: a machine takes no
// such datagram from the network.
void Outsider::announce(MonotonicTime now, std::size_t nodes) {
  Forger forger(ledger_, invariants_, recorded_, further_);
  for (auto& [octets, from] : forger.announcements(nodes))
    if (const auto to = address_of(further_.below(nodes)); to != from)
      inject({from, to, std::move(octets)}, now);
}

void Outsider::crowd(MonotonicTime now) {
  Forger forger(ledger_, invariants_, recorded_, further_);
  for (auto& [octets, from] : forger.crowd()) inject({from, kGroup, std::move(octets)}, now);
}

void Outsider::ambush(MonotonicTime now) {
  auto octets = Ambush(ledger_, invariants_, recorded_, ambush_)(now);
  const auto from = Locator::udp_v4({192, 0, 2, ambush_.octet()}, 7400);
  if (!octets.empty()) inject({from, kGroup, std::move(octets)}, now);
}

std::vector<GuidPrefix> Outsider::names() const {
  std::vector<GuidPrefix> out;
  for (const auto& [prefix, life] : ledger_.lives()) out.push_back(prefix);
  return out;
}

Bytes Outsider::spliced(const Bytes& octets) {
  return splice(octets, dice_.of(recorded_).octets, dice_);
}

}  // namespace ddssec::rtps::sim
