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

/// The last number, so that nothing that a stranger sent before makes ours late.
constexpr rtps::SequenceNumber kLast{std::numeric_limits<std::int64_t>::max()};

/// DDS-XTypes 7.6.3.3.3
constexpr EntityId kTypeLookupRequestWriter{{0x00, 0x03, 0x00, 0xc3}};
constexpr EntityId kTypeLookupReplyWriter{{0x00, 0x03, 0x01, 0xc3}};

/// In this order: the writer that says so goes last.
std::vector<EntityId> writers_to_end(TypeLookup lookup) {
  std::vector<EntityId> writers = {rtps::kSubscriptionsWriter, rtps::kPublicationsWriter};
  if (lookup == TypeLookup::ends)
    writers.insert(writers.begin(), {kTypeLookupRequestWriter, kTypeLookupReplyWriter});
  return writers;
}

}  // namespace

Bytes write_end_of_clear_discovery(const GuidPrefix& peer, const GuidPrefix& own,
                                   TypeLookup lookup) {
  const auto writers = writers_to_end(lookup);
  rtps::SequenceNumber number{kLast.value - static_cast<std::int64_t>(writers.size() - 1)};
  Bytes octets(512);
  rtps::SpanWriter out(octets);
  write(out, rtps::Header{.prefix = peer});
  write(out, rtps::InfoDestination{own});
  write(out, rtps::Heartbeat{.reader = rtps::kPublicationsReader,
                             .writer = rtps::kPublicationsWriter,
                             .first = number,
                             .last = kLast,
                             .count = 1,
                             .is_final = true});
  for (const auto& writer : writers) {
    write(out, Disposal{.reader = rtps::kPublicationsReader,
                        .writer = rtps::kPublicationsWriter,
                        .number = number,
                        .key = kEndpointGuid,
                        .gone = {peer, writer}});
    if (number < kLast) number = number.next();
  }
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

void ClearDiscovery::established(spi::IdentityHandle local, const GuidPrefix& own, const Guid& peer,
                                 TypeLookup lookup) {
  const std::lock_guard lock(mutex_);
  peers_.insert_or_assign(
      peer, Peer{.local = local, .own = own, .lookup = lookup, .since = clock_.monotonic()});
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
      out.push_back({write_end_of_clear_discovery(guid.prefix, peer.own, peer.lookup), at->second});
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
