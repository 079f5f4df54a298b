#include "plugins/cryptography/routes.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/wire.hpp"

namespace ddssec::cryptography {
namespace {

/// Runs up to this length always become one: with few endpoints there is one run to look through.
constexpr std::size_t kShortRun = 64;

std::span<const Route> with_key(const std::vector<Route>& run, KeyId key) {
  const auto same = std::ranges::equal_range(run, key, {}, &Route::key_id);
  return {same.begin(), same.end()};
}

/// Those of one receiver-specific key, from the first for this local participant on.
std::span<const Route> with_receiver_key(std::span<const Route> routes, KeyId id,
                                         std::int64_t receiver) {
  const auto place = [](const Route& one) {
    return std::tuple(one.receiver_key_id, one.local_participant);
  };
  const auto begin = std::ranges::lower_bound(routes, std::tuple(id, receiver), {}, place);
  const auto end = std::ranges::upper_bound(begin, routes.end(), id, {}, &Route::receiver_key_id);
  return {begin, end};
}

}  // namespace

RemoteEndpoint* Routes::endpoint_of(const Route& route) const {
  const auto found = registry_.find<RemoteEndpoint>(route.handle, route.kind);
  return found && (*found)->route == route.number ? *found : nullptr;
}

Routes::Found Routes::first_of(std::span<const Route> routes, std::int64_t receiver) const {
  for (const auto& route : routes) {
    if (receiver != 0 && route.local_participant != receiver) continue;
    if (auto* const endpoint = endpoint_of(route)) return {&route, endpoint};
  }
  return {};
}

RemoteEndpoint* Routes::find(KeyId key, std::int64_t receiver, BytesView group) const {
  const auto* const table = table_.read();
  if (table == nullptr) return nullptr;
  std::size_t candidates = 0;
  Found first;
  for (const auto& run : table->runs) {
    const auto routes = with_key(*run, key);
    candidates += routes.size();
    const auto found = first_of(routes, receiver);
    if (found.route != nullptr && (first.route == nullptr || *found.route < *first.route))
      first = found;
  }
  if (first.route == nullptr || candidates == 1 || first.route->receiver_key_id.is_zero())
    return first.endpoint;
  auto* const meant = find_by_mac(*table, key, receiver, group);
  return meant != nullptr ? meant : first.endpoint;
}

/// From MAC to route, not the other way round: the sender chooses how many there are of each.
RemoteEndpoint* Routes::find_by_mac(const Table& table, KeyId key, std::int64_t receiver,
                                    BytesView group) const {
  const auto message = read_protected_group(group, kSubmessageFrame);
  if (!message) return nullptr;
  for (auto macs = message->footer.receiver_macs; !macs.empty();
       macs = macs.subspan(kReceiverMacSize)) {
    const auto id = KeyId::from(macs.first(KeyId::size));
    for (const auto& run : table.runs)
      if (const auto found =
              first_of(with_receiver_key(with_key(*run, key), id, receiver), receiver);
          found.endpoint != nullptr)
        return found.endpoint;
  }
  return nullptr;
}

EntityId Routes::other_owner(KeyId key, const EntityId& owner) const {
  const auto* const table = table_.read();
  if (table == nullptr) return {};
  for (const auto& run : table->runs)
    for (const auto& route : with_key(*run, key)) {
      const auto* const endpoint = endpoint_of(route);
      if (endpoint == nullptr || endpoint->local.is_volatile) continue;
      const auto& other = endpoint->remote_keys.read()->owner;
      if (!other.is_zero() && other != owner) return other;
    }
  return {};
}

Routes::Run Routes::merged(const Run& a, const Run& b) const {
  Run both;
  both.reserve(a.size() + b.size());
  std::ranges::merge(a, b, std::back_inserter(both));
  std::erase_if(both, [&](const Route& one) { return endpoint_of(one) == nullptr; });
  return both;
}

void Routes::add(const Route& route, Graveyard& graveyard) {
  auto next = std::make_unique<Table>();
  if (const auto* const present = table_.read()) next->runs = present->runs;
  std::size_t size = 0;
  for (const auto& run : next->runs) size += run->size();
  const bool merges_all = 2 * gone_ > size;
  Run last{route};
  while (!next->runs.empty() &&
         (merges_all || next->runs.back()->size() <= std::max(last.size(), kShortRun))) {
    last = merged(*next->runs.back(), last);
    next->runs.pop_back();
  }
  std::size_t dropped = size + 1 - last.size();
  for (const auto& run : next->runs) dropped -= run->size();
  next->runs.push_back(std::make_shared<const Run>(std::move(last)));
  table_.replace(std::move(next), graveyard);
  gone_ -= std::min(gone_, dropped);
}

}  // namespace ddssec::cryptography
