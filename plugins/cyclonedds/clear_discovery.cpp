#include "plugins/cyclonedds/clear_discovery.hpp"

#include <algorithm>
#include <limits>

#include "plugins/cyclonedds/disposal.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_destination.hpp"
#include "wire/locator.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::cyclonedds {
namespace {

/// The last numbers, so that nothing that a stranger sent before makes ours late.
constexpr rtps::SequenceNumber kLast{std::numeric_limits<std::int64_t>::max()};

void dispose(rtps::SpanWriter& out, const Guid& endpoint, rtps::SequenceNumber number) {
  write(out, Disposal{.reader = rtps::kPublicationsReader,
                      .writer = rtps::kPublicationsWriter,
                      .number = number,
                      .key = kEndpointGuid,
                      .gone = endpoint});
}

}  // namespace

Bytes write_end_of_clear_discovery(const GuidPrefix& peer, const GuidPrefix& own) {
  Bytes octets(256);
  rtps::SpanWriter out(octets);
  write(out, rtps::Header{.prefix = peer});
  write(out, rtps::InfoDestination{own});
  write(out, rtps::Heartbeat{.reader = rtps::kPublicationsReader,
                             .writer = rtps::kPublicationsWriter,
                             .first = kLast.previous(),
                             .last = kLast,
                             .count = 1,
                             .is_final = true});
  dispose(out, {peer, rtps::kSubscriptionsWriter}, kLast.previous());
  dispose(out, {peer, rtps::kPublicationsWriter}, kLast);
  octets.resize(out.size());
  return octets;
}

std::vector<spi::UdpAddress> discovery_addresses(BytesView participant_data) {
  constexpr rtps::ParameterId kMetatrafficUnicastLocator = 0x0032;
  constexpr std::size_t kMost = 8;
  std::vector<spi::UdpAddress> out;
  rtps::ParameterReader parameters(participant_data, Endian::big);
  while (out.size() < kMost) {
    const auto parameter = parameters.next();
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != kMetatrafficUnicastLocator) continue;
    auto reader = (*parameter)->reader();
    const auto locator = rtps::read_locator(reader);
    if (!locator || !locator->is_usable() || locator->is_multicast()) continue;
    out.push_back({.is_ipv6 = locator->kind == rtps::LocatorKind::udp_v6,
                   .port = static_cast<std::uint16_t>(locator->port),
                   .address = locator->address});
  }
  return out;
}

void ClearDiscovery::hears_at(spi::IdentityHandle local, std::vector<spi::UdpAddress> addresses) {
  const std::lock_guard lock(mutex_);
  addresses_[local] = std::move(addresses);
}

void ClearDiscovery::remove_local(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  addresses_.erase(local);
  std::erase_if(peers_, [&](const auto& entry) { return entry.second.local == local; });
}

void ClearDiscovery::established(spi::IdentityHandle local, const GuidPrefix& own,
                                 const Guid& peer) {
  const std::lock_guard lock(mutex_);
  peers_.insert_or_assign(peer, Peer{.local = local, .own = own, .since = clock_.monotonic()});
}

void ClearDiscovery::lost(const Guid& peer) {
  const std::lock_guard lock(mutex_);
  peers_.erase(peer);
}

std::vector<ClearDiscovery::Due> ClearDiscovery::due() {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  std::vector<Due> out;
  for (auto& [guid, peer] : peers_) {
    if (now - peer.since < kTimes.at(peer.said)) continue;
    while (peer.said < kTimes.size() && now - peer.since >= kTimes.at(peer.said)) ++peer.said;
    if (const auto at = addresses_.find(peer.local); at != addresses_.end())
      out.push_back({write_end_of_clear_discovery(guid.prefix, peer.own), at->second});
  }
  std::erase_if(peers_, [](const auto& entry) { return entry.second.said == kTimes.size(); });
  return out;
}

std::optional<ClearDiscovery::Duration> ClearDiscovery::next() const {
  const std::lock_guard lock(mutex_);
  std::optional<Duration> out;
  const auto now = clock_.monotonic();
  for (const auto& [guid, peer] : peers_) {
    const auto left = std::max(Duration(0), peer.since + kTimes.at(peer.said) - now);
    out = std::min(out.value_or(left), left);
  }
  return out;
}

}  // namespace ddssec::cyclonedds
