// A writer that applies the content filters of its readers shows for each sample which of them it
// passes, in its inline QoS or by a GAP. An attacker may announce a filter in a reader's name.
#include "tests/attack/rtps/forged_announcements.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Participant a writes and b reads. The discovery of the topic is not protected.
struct FilterOracle : ForgedAnnouncements {
  FilterOracle(ProtectionKind metadata, ProtectionKind data)
      : ForgedAnnouncements(Kind::readers_of_b, {.discovery = ProtectionKind::encrypt,
                                                 .metadata = metadata,
                                                 .data = data,
                                                 .clear_topics = true}) {
    pair.a.listener.filter = std::make_shared<FixedFilter>(false);
  }
  void announce_with_filter(EndpointData endpoint) {
    endpoint.content_filter = ContentFilterProperty{.content_filtered_topic_name = "Chosen",
                                                    .related_topic_name = endpoint.topic_name,
                                                    .filter = {"x = 1", {}}};
    announce(endpoint);
    pair.world.run(20);
  }
  std::size_t filtered() const {
    return pair.a.participant->local_endpoints().writer(pair.writer)->readers().filtered();
  }
};

constexpr auto kNone = ProtectionKind::none, kSign = ProtectionKind::sign,
               kEncrypt = ProtectionKind::encrypt;

TEST(ContentFilterOracle, OnAnEncryptedTopic_TellsNothing) {
  for (const auto& [metadata, data] : {std::pair(kNone, kEncrypt), std::pair(kSign, kEncrypt),
                                       std::pair(kEncrypt, kNone), std::pair(kEncrypt, kEncrypt)}) {
    FilterOracle oracle(metadata, data);
    oracle.announce_with_filter(oracle.forged_endpoint(1));
    oracle.announce_with_filter(oracle.true_endpoint);
    EXPECT_EQ(oracle.filtered(), 0u);
    oracle.pair.write();
    EXPECT_TRUE(
        oracle.pair.world.run_until([&] { return oracle.pair.b.listener.changes.size() == 1; }));
  }
}

TEST(ContentFilterOracle, OnATopicThatAllCanRead_FiltersAreApplied) {
  for (const auto& [metadata, data] : {std::pair(kNone, kNone), std::pair(kNone, kSign)}) {
    FilterOracle oracle(metadata, data);
    oracle.announce_with_filter(oracle.true_endpoint);
    EXPECT_EQ(oracle.filtered(), 1u);
  }
}

}  // namespace
}  // namespace ddssec::rtps
