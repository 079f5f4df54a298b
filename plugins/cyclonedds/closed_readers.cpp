#include "plugins/cyclonedds/closed_readers.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace ddssec::cyclonedds {
namespace {

constexpr auto kClearDiscovery =
    std::to_array<std::string_view>({"DCPSPublication", "DCPSSubscription", "DCPSTopic"});
constexpr auto kTypeLookup =
    std::to_array<std::string_view>({"DCPSTypeLookupRequest", "DCPSTypeLookupReply"});

bool is_among(std::span<const std::string_view> topics, std::string_view topic) {
  return std::ranges::find(topics, topic) != topics.end();
}

}  // namespace

bool is_closed(const spi::EndpointRequest& reader,
               const spi::ParticipantSecurityAttributes& participant, TypeLookup lookup) {
  // In a partition of the core, applications read topics with the same names.
  if (!reader.partitions.empty()) return false;
  if (is_among(kTypeLookup, reader.topic_name)) return lookup == TypeLookup::closed;
  return participant.is_all_discovery_protected && is_among(kClearDiscovery, reader.topic_name);
}

}  // namespace ddssec::cyclonedds
