#include "rtps/participant/remote_participants.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/rollback.hpp"

namespace ddssec::rtps {
namespace {

std::size_t price_of(const EndpointData& data) {
  return RemoteParticipants::kPricePerEndpoint + octets_of(data);
}

// Takes the endpoint out of the shares in which it counts as it is stored.
void discount(std::array<AnnouncedShares, 2>& all, RemoteParticipant& remote,
              const RemoteEndpoint& endpoint) {
  const AnnouncedShares::Amount less{endpoint.price, 1};
  remote.announced[endpoint.is_proven ? 1 : 0] -= less;
  all[endpoint.is_proven ? 1 : 0].remove(remote.account, less);
}

// Returns kNever if the lease does not end.
MonotonicTime lease_of(const ParticipantCore& core, const ParticipantData& data) {
  const auto announced =
      data.lease_duration.is_infinite() ? kNever : data.lease_duration.to_nanoseconds();
  return core.security ? std::min<MonotonicTime>(announced, RemoteParticipants::kMaxLease)
                       : announced;
}

// Returns the end of the lease of a participant that is heard now.
MonotonicTime lease_end(const ParticipantCore& core, const ParticipantData& data) {
  const auto lease = lease_of(core, data);
  return lease == kNever ? kNever : core.now + lease;
}

// Returns the index of the locator that is replaced when `newcomer` adds one more. It is chosen
// from the source with the most locators: the one in the middle, so that the first locators of
// that source and the latest of the others stay.
std::size_t superfluous(const std::vector<SourceAddress>& sources, const SourceAddress& newcomer) {
  const auto held = [&](const SourceAddress& source) {
    return std::pair(std::ranges::count(sources, source), source == newcomer);
  };
  const auto largest = *std::ranges::max_element(sources, {}, held);
  auto left = held(largest).first / 2;
  std::size_t at = 0;
  while (sources[at] != largest || left-- > 0) ++at;
  return at;
}

}  // namespace

// An announcement may name any address. Only a few are used, and only those that can be sent to.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback,
                            std::span<const NetworkInterface> own) {
  constexpr std::size_t kMaxUsed = 4;
  LocatorList out;
  for (const auto& locator : announced)
    if (locator.is_usable() && !locator.is_multicast()) out.push_back(locator);
  keep_nearest(out, own);
  if (out.size() > kMaxUsed) out.resize(kMaxUsed);
  return out.empty() ? fallback : out;
}

void RemoteParticipant::watch(EndpointListener& reader, const EndpointData& writer,
                              MonotonicTime now) {
  const auto& liveliness = writer.qos.liveliness;
  if (liveliness.lease_duration.is_infinite()) return;
  if (liveliness.kind == LivelinessKind::manual_by_topic) {
    watches[writer.guid.entity].push_back(&reader);
    return reader.on_signal(writer.guid, nullptr);
  }
  auto& shared = signal(liveliness.kind);
  if (shared == nullptr) shared = std::make_shared<LivelinessSignal>(now);
  reader.on_signal(writer.guid, shared);
}

void RemoteParticipant::stop_watching(EndpointListener& reader, const Guid& writer) {
  for (auto& shared : signals)
    if (shared != nullptr) shared->forget(reader, writer);
  const auto at = watches.find(writer.entity);
  if (at == watches.end()) return;
  std::erase(at->second, &reader);
  if (at->second.empty()) watches.erase(at);
}

RemoteParticipants::RemoteParticipants(ParticipantCore& core) : core_(core) {
  self_.data.guid = {core.config.prefix, kEntityIdParticipant};
}

RemoteParticipant* RemoteParticipants::find(const GuidPrefix& prefix) {
  const auto at = remotes_.find(prefix);
  return at == remotes_.end() ? nullptr : &at->second;
}

RemoteParticipant* RemoteParticipants::find_or_self(const GuidPrefix& prefix) {
  return prefix == self_.prefix() ? &self_ : find(prefix);
}

RemoteEndpoint* RemoteParticipants::find_endpoint(const Guid& guid) {
  auto* remote = find_or_self(guid.prefix);
  if (remote == nullptr) return nullptr;
  const auto endpoint = remote->endpoints.find(guid.entity);
  return endpoint == remote->endpoints.end() ? nullptr : &endpoint->second;
}

bool RemoteParticipants::is_full(std::size_t octets) const {
  return remotes_.size() >= kMaxParticipants || (core_.security && !unproven_.has_room(octets));
}

RemoteParticipant& RemoteParticipants::add(ParticipantData data, LocatorList metatraffic,
                                           LocatorList user, std::size_t octets) {
  const auto prefix = data.guid.prefix;
  const auto end = lease_end(core_, data);
  next_end_ = std::min(next_end_, end);
  auto& remote =
      remotes_[prefix] = {std::move(data), std::move(metatraffic), std::move(user), end, core_.now};
  remote.account = prefix;
  remote.source = core_.source;
  remote.metatraffic_sources.assign(remote.metatraffic.size(), core_.source);
  remote.user_sources.assign(remote.user.size(), core_.source);
  if (core_.security) {
    remote.unproven = octets;
    unproven_.add(core_.source, prefix, octets);
  }
  return remote;
}

bool RemoteParticipants::grow(RemoteParticipant& remote, std::size_t octets) {
  if (!remote.unproven || octets <= *remote.unproven) return true;
  const auto more = octets - *remote.unproven;
  if (!unproven_.has_room(more)) return false;
  unproven_.grow(remote.source, more);
  remote.unproven = octets;
  return true;
}

void RemoteParticipants::discharge(RemoteParticipant& remote) {
  if (remote.unproven) unproven_.remove(remote.source, *remote.unproven);
  remote.unproven.reset();
}

void RemoteParticipants::remove(const GuidPrefix& prefix) {
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return;
  if (at->second.accepted && discovery_ != nullptr)
    discovery_->on_participant_gone(at->second.data.guid);
  discharge(at->second);
  remotes_.erase(at);
}

RemoteParticipant& RemoteParticipants::restore(RemoteParticipant known) {
  const auto prefix = known.prefix();
  auto& remote = remotes_.insert_or_assign(prefix, std::move(known)).first->second;
  remote.since = core_.now;
  remote.has_returned = true;
  renew_lease(remote, remote.data);
  return remote;
}

// Without security a participant cannot prove anything. One host can announce many participants and
// send messages in their names, but only from its own addresses.
std::optional<GuidPrefix> RemoteParticipants::next_to_evict() {
  if (!core_.security) return std::nullopt;
  const auto source = unproven_.largest(core_.source, remotes_.size() < kMaxParticipants);
  if (!source) return std::nullopt;
  const auto is_its = [&](const RemoteParticipant& remote) {
    return remote.unproven && remote.source == *source && !core_.is_authenticated(remote.prefix());
  };
  const auto silent = unproven_.oldest_silent(*source, [&](const GuidPrefix& prefix) {
    const auto* remote = find(prefix);
    return remote != nullptr && is_its(*remote) && !core_.security->has_spoken(prefix);
  });
  if (silent) return silent;
  const RemoteParticipant* oldest = nullptr;
  for (const auto& [prefix, remote] : remotes_)
    if (is_its(remote) && (oldest == nullptr || remote.since < oldest->since)) oldest = &remote;
  return oldest == nullptr ? std::nullopt : std::optional(oldest->prefix());
}

void RemoteParticipants::accept(RemoteParticipant& remote) {
  if (core_.is_authenticated(remote.prefix())) {
    // From now on its endpoints count for its identity.
    const auto identity = core_.identity_of(remote.prefix());
    for (const std::size_t proven : {0u, 1u}) {
      announced_[proven].add(identity, remote.announced[proven]);
      announced_[proven].remove(remote.account, remote.announced[proven]);
    }
    remote.account = identity;
    discharge(remote);
  }
  if (!std::exchange(remote.accepted, true)) on_changed(remote);
}

void RemoteParticipants::on_changed(const RemoteParticipant& remote) {
  if (remote.accepted && discovery_ != nullptr) discovery_->on_participant(remote.data);
}

// Until a peer has authenticated, its lease is long enough for the handshake.
void RemoteParticipants::renew_lease(RemoteParticipant& remote, const ParticipantData& data) {
  const auto end = lease_end(core_, data);
  const bool proven = !core_.security || !core_.security->is_authenticating(data.guid.prefix);
  remote.lease_end = proven ? end : std::max({remote.lease_end, end, core_.now + kMinLease});
  next_end_ = std::min(next_end_, remote.lease_end);
  if (!core_.security) return;
  remote.next_query = next_time(data, kSilentPartOfLease);
  next_query_ = std::min(next_query_, remote.next_query);
}

MonotonicTime RemoteParticipants::next_time(const ParticipantData& data, int share) const {
  const auto lease = lease_of(core_, data);
  return lease == kNever ? kNever : core_.now + std::max<MonotonicTime>(lease / share, kMinPause);
}

// Every message extends a lease, so the noted times may be too early but never too late.
RemoteParticipants::Due RemoteParticipants::take_due() {
  Due out;
  const bool any_query = core_.now >= next_query_, any_end = core_.now >= next_end_;
  if (any_query) next_query_ = kNever;
  if (any_end) next_end_ = kNever;
  for (auto& [prefix, remote] : remotes_) {
    if (!any_query && !any_end) break;
    if (any_query && remote.next_query <= core_.now) {
      const bool is_asked = core_.is_authenticated(prefix);
      if (is_asked) out.queries.push_back(prefix);
      const auto next = next_time(remote.data, kQueriesPerLease);
      remote.next_query = is_asked ? next : std::max(next, core_.now + kPauseOfUnproven);
    }
    if (any_query) next_query_ = std::min(next_query_, remote.next_query);
    if (!any_end) continue;
    const bool is_next = remote.lease_end <= core_.now && out.ended_leases.size() < kMaxEndsAtOnce;
    if (is_next)
      out.ended_leases.push_back(prefix);
    else
      next_end_ = std::min(next_end_, remote.lease_end);
  }
  return out;
}

void RemoteParticipants::raise_about(Error error, const EntityId& local, const Guid& remote) const {
  core_.raise_about(std::move(error), local, remote);
}

// A participant that announces much does not displace those that announce little, however many
// there are of its identity.
bool RemoteParticipants::has_room(RemoteParticipant& remote, const EndpointData& endpoint) {
  const auto price = price_of(endpoint);
  const std::size_t proven = core_.is_proven(endpoint) ? 1 : 0;
  const auto known = remote.endpoints.find(endpoint.guid.entity);
  const bool replaces = known != remote.endpoints.end() && known->second.is_proven == (proven == 1);
  const AnnouncedShares::Amount more{price, 1};
  const auto less =
      replaces ? AnnouncedShares::Amount{known->second.price, 1} : AnnouncedShares::Amount{};
  auto own = remote.announced[proven];
  (own += more) -= less;
  const bool fits = own.octets <= kMaxEndpointOctetsPerParticipant &&
                    own.endpoints <= kMaxEndpointsPerParticipant &&
                    announced_[proven].has_room(remote.account, more, less);
  if (fits || own.octets <= kEndpointOctetsOfEach) return true;
  ++core_.counters.refused_discovery;
  const auto& before = remote.announced[proven];
  if (!std::exchange(remote.exceeds[proven], true))
    core_.raise_about(
        Error(Code::rtps_too_many_endpoints,
              {.found = fmt::format("{} endpoints of {} octets", before.endpoints, before.octets)}),
        endpoint);
  return false;
}

RemoteEndpoint& RemoteParticipants::store(RemoteParticipant& remote, EndpointData data) {
  const AnnouncedShares::Amount more{price_of(data), 1};
  const bool is_proven = core_.is_proven(data);
  const auto [at, is_new] = remote.endpoints.try_emplace(data.guid.entity);
  auto& endpoint = at->second;
  Rollback counted([&, place = at, added = is_new] {
    if (added) remote.endpoints.erase(place);
  });
  announced_[is_proven ? 1 : 0].add(remote.account, more);
  counted.release();
  if (!is_new) discount(announced_, remote, endpoint);
  remote.announced[is_proven ? 1 : 0] += more;
  endpoint.price = more.octets;
  endpoint.is_proven = is_proven;
  endpoint.data = std::move(data);
  if (discovery_ != nullptr) discovery_->on_endpoint(endpoint.data);
  return endpoint;
}

void RemoteParticipants::remove(RemoteParticipant& remote, const EntityId& id) {
  const auto known = remote.endpoints.find(id);
  if (known == remote.endpoints.end()) return;
  if (discovery_ != nullptr) discovery_->on_endpoint_gone(known->second.data);
  discount(announced_, remote, known->second);
  remote.clear_addresses.release(id);
  remote.endpoints.erase(known);  // `id` may be the key of this entry
}

void RemoteParticipants::set_discovery_listener(DiscoveryListener* listener) {
  discovery_ = listener;
  if (discovery_ == nullptr) return;
  for (const auto& [prefix, remote] : remotes_) {
    if (remote.accepted) discovery_->on_participant(remote.data);
    for (const auto& [id, endpoint] : remote.endpoints) discovery_->on_endpoint(endpoint.data);
  }
}

std::vector<ParticipantData> RemoteParticipants::participants() const {
  std::vector<ParticipantData> out;
  for (const auto& [prefix, remote] : remotes_)
    if (remote.accepted) out.push_back(remote.data);
  return out;
}

std::vector<EndpointData> RemoteParticipants::endpoints() const {
  std::vector<EndpointData> out;
  for (const auto& [prefix, remote] : remotes_)
    for (const auto& [id, endpoint] : remote.endpoints) out.push_back(endpoint.data);
  return out;
}

const EndpointData* RemoteParticipants::endpoint(const Guid& guid) const {
  const auto at = remotes_.find(guid.prefix);
  const auto* remote = guid.prefix == self_.prefix() ? &self_
                       : at == remotes_.end()        ? nullptr
                                                     : &at->second;
  if (remote == nullptr) return nullptr;
  const auto endpoint = remote->endpoints.find(guid.entity);
  return endpoint == remote->endpoints.end() ? nullptr : &endpoint->second.data;
}

AddedLocators add_locators(LocatorList& known, std::vector<SourceAddress>& sources,
                           const LocatorList& more, const SourceAddress& source) {
  constexpr std::size_t kMax = 8;
  AddedLocators out;
  for (const auto& locator : more) {
    if (std::ranges::find(known, locator) != known.end()) continue;
    out.has_new = true;
    if (known.size() >= kMax) {
      out.has_displaced = true;
      const auto at = static_cast<std::ptrdiff_t>(superfluous(sources, source));
      known.erase(known.begin() + at);
      sources.erase(sources.begin() + at);
    }
    known.push_back(locator);
    sources.push_back(source);
  }
  return out;
}

}  // namespace ddssec::rtps
