// An access control adapter over a mocked plugin.
#pragma once

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::access_control_adapters {

using testing::Field;

/// Returns the scope that make_scope makes for a reader of "Square".
inline spi::PropertyList scope_of(std::uint64_t adapter) {
  DDS_Security_PropertySeq properties{};
  const std::vector<std::string_view> partitions = {"p", "q"};
  const spi::PropertyList tags = {{"colour", "red"}};
  EXPECT_TRUE(make_scope(
      adapter, {.topic_name = "Square", .partitions = partitions, .data_tags = tags}, properties));
  auto list = properties_from(properties).value();
  free_scope(properties);
  return list;
}

struct AccessControlAdapterTest : testing::Test {
  AccessControlAdapterTest() {
    EXPECT_TRUE(copy_token(sample_token(), token));
    publication.topic_name = topic.data();
    subscription.topic_name = topic.data();
    topic_data.name = topic.data();
  }
  ~AccessControlAdapterTest() override { free_token(token); }

  auto asks_for_topic() { return Field(&spi::EndpointRequest::topic_name, "Square"); }

  Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> harness;
  dds_security_access_control* c = &harness.adapter;
  MockAccessControl& plugin = *harness.plugin;
  Refusal refusal;
  DDS_Security_Qos qos{};
  DDS_Security_DataHolder token{};
  std::string topic = "Square";
  DDS_Security_PublicationBuiltinTopicDataSecure publication{};
  DDS_Security_SubscriptionBuiltinTopicDataSecure subscription{};
  DDS_Security_TopicBuiltinTopicData topic_data{};
};

}  // namespace ddssec::cyclonedds::access_control_adapters
