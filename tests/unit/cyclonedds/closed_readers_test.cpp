#include "plugins/cyclonedds/closed_readers.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

constexpr auto kDiscovery = {"DCPSPublication", "DCPSSubscription", "DCPSTopic"};
constexpr auto kLookup = {"DCPSTypeLookupRequest", "DCPSTypeLookupReply"};
constexpr spi::ParticipantSecurityAttributes kAllProtected{.is_all_discovery_protected = true};
constexpr spi::ParticipantSecurityAttributes kSomeClear{};

bool is_closed(std::string_view topic, const spi::ParticipantSecurityAttributes& participant,
               TypeLookup lookup) {
  return cyclonedds::is_closed({.topic_name = topic}, participant, lookup);
}

TEST(ClosedReader, ClearDiscovery_IsClosedWhereTheDiscoveryOfAllTopicsIsProtected) {
  for (const auto* topic : kDiscovery) {
    EXPECT_TRUE(is_closed(topic, kAllProtected, TypeLookup::open)) << topic;
    EXPECT_FALSE(is_closed(topic, kSomeClear, TypeLookup::closed)) << topic;
  }
}

TEST(ClosedReader, TypeLookup_IsClosedUnderEveryGovernanceUnlessTypesAreTrusted) {
  for (const auto* topic : kLookup) {
    EXPECT_TRUE(is_closed(topic, kSomeClear, TypeLookup::closed)) << topic;
    EXPECT_FALSE(is_closed(topic, kAllProtected, TypeLookup::open)) << topic;
  }
}

TEST(ClosedReader, OtherTopics_AreNotClosed) {
  for (const auto* topic :
       {"DCPSParticipant", "DCPSParticipantMessage", "DCPSPublicationsSecure",
        "DCPSParticipantStatelessMessage", "DCPSParticipantVolatileMessageSecure", "Square"})
    EXPECT_FALSE(is_closed(topic, kAllProtected, TypeLookup::closed)) << topic;
}

// An application that reads the core's own topics gets no samples from other processes.
TEST(ClosedReader, ApplicationsOwnReader_IsNotClosed) {
  const std::string_view partitions[] = {"__BUILT-IN PARTITION__"};
  EXPECT_FALSE(cyclonedds::is_closed({.topic_name = "DCPSPublication", .partitions = partitions},
                                     kAllProtected, TypeLookup::closed));
}

}  // namespace
}  // namespace ddssec::cyclonedds
