#include "plugins/cyclonedds/exempt_topics.hpp"

#include <algorithm>
#include <array>

#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {

bool is_local_builtin_topic(std::string_view name) {
  constexpr std::array<std::string_view, 4> kTopics = {"DCPSParticipant", "DCPSTopic",
                                                       "DCPSPublication", "DCPSSubscription"};
  return std::ranges::find(kTopics, name) != kTopics.end();
}

bool reads_local_builtin_topic(const spi::EndpointRequest& request) {
  return is_local_builtin_topic(request.topic_name) && request.partitions.size() == 1 &&
         request.partitions[0] == "__BUILT-IN PARTITION__";
}

bool is_carrier_topic(std::string_view name,
                      const spi::ParticipantSecurityAttributes& participant) {
  return name == kCarrierTopic && participant.is_discovery_protected();
}

}  // namespace ddssec::cyclonedds
