#include "plugins/cryptography/routes.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/key_revision.hpp"

namespace ddssec::cryptography {
namespace {

// Runs up to this length are always merged, so that with few endpoints there is only one run to
// search.
constexpr std::size_t kShortRun = 64;
// A run is merged with those after it as soon as their length is at least this fraction of its
// own. Few runs keep lookups cheap, at the cost of more copies.
constexpr std::size_t kShare = 8;

std::tuple<KeyId, KeyId, std::int64_t> place_of(const Route& route) {
  return {route.key_id, route.receiver_key_id, route.local_participant};
}

}  // namespace

RemoteEndpointCrypto* Routes::endpoint_of(const Route& route) const {
  const auto found = registry_.find<RemoteEndpointCrypto>(route.handle, route.kind);
  return found && (*found)->route == route.number ? *found : nullptr;
}

// Returns the first route that leads to an endpoint, among the routes at the beginning that are
// `like`.
template <class Like>
Routes::FoundRoute Routes::first_of(std::span<const Route> routes, std::int64_t receiver,
                                    Like&& like) const {
  for (const auto& route : routes) {
    if (!like(route)) break;
    if (receiver != 0 && route.local_participant != receiver) continue;
    if (auto* const endpoint = endpoint_of(route)) return {&route, endpoint};
  }
  return {};
}

RemoteEndpointCrypto* Routes::find(KeyId key, std::int64_t receiver, BytesView group) const {
  const auto* const table = table_.read();
  if (table == nullptr) return nullptr;
  const auto has_key = [&](const Route& one) { return one.key_id == key; };
  FoundRoute first;
  std::size_t candidates = 0;
  for (const auto run : table->runs()) {
    const auto at = std::ranges::lower_bound(run, key, {}, &Route::key_id);
    if (at == run.end() || !has_key(*at)) continue;
    candidates += at + 1 != run.end() && has_key(at[1]) ? 2 : 1;
    const auto found = first_of({at, run.end()}, receiver, has_key);
    if (found.route != nullptr && (first.route == nullptr || *found.route < *first.route))
      first = found;
  }
  if (first.route == nullptr || candidates == 1 || first.route->receiver_key_id.is_zero())
    return first.endpoint;
  auto* const meant = find_by_mac(*table, key, receiver, group);
  return meant != nullptr ? meant : first.endpoint;
}

// Searches from MAC to route, not the other way round, because the sender chooses the number of
// each.
RemoteEndpointCrypto* Routes::find_by_mac(const Table& table, KeyId key, std::int64_t receiver,
                                          BytesView group) const {
  const auto message = read_protected_group(group, kSubmessageFrame);
  if (!message) return nullptr;
  for (auto macs = message->footer.receiver_macs; !macs.empty();
       macs = macs.subspan(kReceiverMacSize)) {
    const auto id = KeyId::from(macs.first(KeyId::size));
    const auto is_for_mac = [&](const Route& one) {
      return one.key_id == key && one.receiver_key_id == id;
    };
    for (const auto run : table.runs()) {
      const auto at = std::ranges::lower_bound(run, std::tuple(key, id, receiver), {}, place_of);
      if (const auto found = first_of({at, run.end()}, receiver, is_for_mac); found.endpoint)
        return found.endpoint;
    }
  }
  return nullptr;
}

EntityId Routes::other_owner(KeyId key, const EntityId& owner) const {
  const auto* const table = table_.read();
  if (table == nullptr) return {};
  for (const auto run : table->runs())
    for (const auto& route : std::ranges::equal_range(run, key, {}, &Route::key_id)) {
      const auto* const endpoint = endpoint_of(route);
      if (endpoint == nullptr || endpoint->local.is_volatile) continue;
      const auto& other = endpoint->remote_keys.read()->owner;
      if (!other.is_zero() && other != owner) return other;
    }
  return {};
}

const ReceiveKey* Routes::same_sender_key(const KeyMaterial& material) const {
  const auto is_same = [&](const KeyMaterial& other) {
    return other.kind == material.kind && other.sender_key_id == material.sender_key_id &&
           other.salt == material.salt && other.sender_key == material.sender_key;
  };
  const auto* const table = table_.read();
  if (table == nullptr) return nullptr;
  for (const auto run : table->runs())
    for (const auto& route :
         std::ranges::equal_range(run, material.sender_key_id, {}, &Route::key_id)) {
      const auto* const endpoint = endpoint_of(route);
      if (endpoint == nullptr || endpoint->local.is_volatile) continue;
      const auto& key = endpoint->remote_keys.read()->submessage;
      if (key && is_same(key->material())) return key.get();
    }
  return nullptr;
}

// Calls `f` with each other endpoint that messages under the key may be routed to instead.
template <class F>
void Routes::each_rival(const RemoteEndpointCrypto& endpoint, F&& f) const {
  const auto* const table = table_.read();
  const auto& key = endpoint.remote_keys.read()->submessage->material();
  if (table == nullptr || !key.receiver_key_id.is_zero()) return;
  if (!endpoint.local.participant.revises_keys) return;  // a host may have very many endpoints
  for (const auto run : table->runs())
    for (const auto& route : std::ranges::equal_range(run, key.sender_key_id, {}, &Route::key_id)) {
      if (route.local_participant != endpoint.local.participant.handle()) continue;
      auto* const rival = endpoint_of(route);
      if (rival != nullptr && rival != &endpoint && !rival->local.is_volatile) f(*rival);
    }
}

bool Routes::is_outdated(const RemoteEndpointCrypto& endpoint) const {
  bool out = false;
  each_rival(endpoint, [&](const RemoteEndpointCrypto& rival) {
    out = out || is_later_revision(*rival.remote_keys.read(), *endpoint.remote_keys.read());
  });
  return out;
}

void Routes::end_outdated(const RemoteEndpointCrypto& endpoint) {
  each_rival(endpoint, [&](RemoteEndpointCrypto& rival) {
    if (!is_later_revision(*endpoint.remote_keys.read(), *rival.remote_keys.read())) return;
    rival.route = 0;
    note_gone();
  });
}

Routes::Run Routes::merged(const Run& a, const Run& b) const {
  Run both;
  both.reserve(a.size() + b.size());
  std::ranges::merge(a, b, std::back_inserter(both));
  std::erase_if(both, [&](const Route& one) { return endpoint_of(one) == nullptr; });
  return both;
}

void Routes::Table::append(std::shared_ptr<const Run> run) {
  views_.emplace_back(*run);
  owners_.push_back(std::move(run));
}

void Routes::add(const Route& route, RetiredObjects& retired_objects) {
  auto next = std::make_unique<Table>();
  std::vector<std::shared_ptr<const Run>> kept;
  if (const auto* const present = table_.read()) kept = present->owners();
  std::size_t size = 0;
  for (const auto& run : kept) size += run->size();
  const bool merges_all = 2 * gone_ > size;
  Run last{route};
  while (!kept.empty() &&
         (merges_all || kept.back()->size() <= std::max(kShare * last.size(), kShortRun))) {
    last = merged(*kept.back(), last);
    kept.pop_back();
  }
  std::size_t dropped = size + 1 - last.size();
  for (auto& run : kept) {
    dropped -= run->size();
    next->append(std::move(run));
  }
  next->append(std::make_shared<const Run>(std::move(last)));
  table_.replace(std::move(next), retired_objects);
  gone_ -= std::min(gone_, dropped);
}

}  // namespace ddssec::cryptography
