#include "plugins/cyclonedds/exempt_topics.hpp"

#include <gtest/gtest.h>

#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {
namespace {

TEST(ExemptTopics, BuiltinTopics_AreKnownByTheirExactName) {
  for (const char* const name :
       {"DCPSParticipant", "DCPSTopic", "DCPSPublication", "DCPSSubscription"})
    EXPECT_TRUE(is_local_builtin_topic(name)) << name;
  for (const char* const name :
       {"", "DCPS", "DCPSTopics", "dcpstopic", "DCPSParticipantSecure", "Square"})
    EXPECT_FALSE(is_local_builtin_topic(name)) << name;
}

// An application can neither create the topic nor name the partition.
TEST(ExemptTopics, ReaderOfABuiltinTopic_IsInTheCoresPartitionAlone) {
  const std::string_view own = "__BUILT-IN PARTITION__";
  const auto reads = [](std::string_view topic, std::vector<std::string_view> partitions) {
    return reads_local_builtin_topic({.topic_name = topic, .partitions = partitions});
  };
  EXPECT_TRUE(reads("DCPSTopic", {own}));
  EXPECT_FALSE(reads("Square", {own}));
  EXPECT_FALSE(reads("DCPSTopic", {}));
  EXPECT_FALSE(reads("DCPSTopic", {"", own}));
  EXPECT_FALSE(reads("DCPSTopic", {own, "more"}));
  EXPECT_FALSE(reads("DCPSTopic", {"__BUILT-IN PARTITION__ "}));
}

TEST(ExemptTopics, Carrier_NeedsProtectedDiscovery) {
  spi::ParticipantSecurityAttributes participant;
  participant.discovery = ProtectionKind::sign;
  EXPECT_TRUE(is_carrier_topic(kCarrierTopic, participant));
  EXPECT_FALSE(is_carrier_topic("Square", participant));
  participant.discovery = ProtectionKind::none;
  EXPECT_FALSE(is_carrier_topic(kCarrierTopic, participant));
}

}  // namespace
}  // namespace ddssec::cyclonedds
