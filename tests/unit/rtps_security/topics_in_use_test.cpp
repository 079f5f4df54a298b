// The topics that access control counts as in use: those on which the host has endpoints. They
// decide which governance documents a running participant takes.
#include <set>

#include "tests/unit/rtps_security/secured_keeper.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

std::set<std::string, std::less<>>& topics_in_use() {
  static std::set<std::string, std::less<>> topics;
  return topics;
}

class TopicRecorder final : public LaxAccessControl {
 public:
  using LaxAccessControl::LaxAccessControl;
  Result<spi::EndpointSecurityAttributes> datawriter_sec_attributes(
      spi::PermissionsHandle local, const spi::EndpointRequest& request) override {
    topics_in_use().emplace(request.topic_name);
    return LaxAccessControl::datawriter_sec_attributes(local, request);
  }
  Result<spi::EndpointSecurityAttributes> datareader_sec_attributes(
      spi::PermissionsHandle local, const spi::EndpointRequest& request) override {
    topics_in_use().emplace(request.topic_name);
    return LaxAccessControl::datareader_sec_attributes(local, request);
  }
  void forget_topic(spi::PermissionsHandle local, std::string_view topic_name) override {
    topics_in_use().erase(std::string(topic_name));
    LaxAccessControl::forget_topic(local, topic_name);
  }
};

std::unique_ptr<spi::AccessControl> recorded(std::unique_ptr<spi::AccessControl> real) {
  topics_in_use().clear();
  return std::make_unique<TopicRecorder>(std::move(real));
}

TEST(TopicsInUse, ATopic_IsInUseUntilItsLastEndpointIsDeleted) {
  ManualClock clock(pki::kNow);
  Secured alice("CN=alice,O=Example", everything(ProtectionKind::encrypt), clock, "", {"*"},
                recorded);
  auto& publisher = alice.participant->create_publisher();
  auto& subscriber = alice.participant->create_subscriber();
  ASSERT_TRUE(publisher.create_datawriter<Sensor>(*alice.topic, default_writer_qos()));
  ASSERT_TRUE(subscriber.create_datareader<Sensor>(*alice.topic, default_reader_qos()));
  EXPECT_TRUE(topics_in_use().contains("Sensors"));
  ASSERT_TRUE(publisher.delete_contained_entities());
  EXPECT_TRUE(topics_in_use().contains("Sensors"));
  ASSERT_TRUE(subscriber.delete_contained_entities());
  EXPECT_FALSE(topics_in_use().contains("Sensors"));
}

// Otherwise a peer fills the list for good: it announces durable writers, and deletes them.
TEST_F(SecuredKeeper, TopicsThatItNoLongerKeeps_AreNotInUse) {
  mallory.reset();
  keeper.reset();
  SecuredProcess of_keeper(clock, recorded);
  keeper = Keeper::create(of_keeper.options("CN=keeper,O=Example", rules), {}, of_keeper.services)
               .value();
  alice.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 1; })) << of_keeper.events.text();
  EXPECT_TRUE(topics_in_use().contains("Sensors"));
  ASSERT_TRUE(alice.participant->delete_contained_entities());
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 0; }));
  EXPECT_FALSE(topics_in_use().contains("Sensors"));
  keeper.reset();
}

}  // namespace
}  // namespace ddssec::rtps
