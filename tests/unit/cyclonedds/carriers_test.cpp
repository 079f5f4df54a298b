// The answers of access control about the readers that carry ends (own_readers.hpp).
#include <atomic>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/own_readers.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "tests/unit/cyclonedds/mocks.hpp"
#include "tests/unit/cyclonedds/support.hpp"

static std::atomic<int> looks_for_ended_readers{0};

namespace ddssec::cyclonedds {
namespace {

struct Carriers : testing::Test {
  // Access control with this protection of discovery. The documents allow nothing.
  void use(ProtectionKind discovery) {
    ON_CALL(plugin, participant_sec_attributes).WillByDefault([discovery](auto) {
      return spi::ParticipantSecurityAttributes{.discovery = discovery};
    });
    ON_CALL(plugin, check_create_topic).WillByDefault([](auto&&...) -> Status {
      return fail(Code::topic_not_allowed);
    });
    ON_CALL(plugin, check_create_datareader).WillByDefault([](auto&&...) -> Status {
      return fail(Code::topic_not_allowed);
    });
    ON_CALL(plugin, check_create_datawriter).WillByDefault([](auto&&...) -> Status {
      return fail(Code::topic_not_allowed);
    });
  }
  bool may_create(const std::string& name) {
    const bool topic = c->check_create_topic(c, 8, 5, name.c_str(), &qos, nullptr) != 0;
    const bool reader =
        c->check_create_datareader(c, 8, 5, name.c_str(), &qos, nullptr, nullptr, nullptr) != 0;
    EXPECT_EQ(topic, reader);
    return reader;
  }

  Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> harness;
  dds_security_access_control* c = &harness.adapter;
  MockAccessControl& plugin = *harness.plugin;
  DDS_Security_Qos qos{};
  const std::string topic{kCarrierTopic};
};

TEST_F(Carriers, ProtectedAnnouncements_NeedNoPermission) {
  use(ProtectionKind::encrypt);
  EXPECT_TRUE(may_create(topic));
  EXPECT_FALSE(may_create(topic + "s"));
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, topic.c_str(), &qos, nullptr, nullptr, nullptr), 0);
}

TEST_F(Carriers, UnprotectedAnnouncements_AreOrdinaryReaders) {
  use(ProtectionKind::none);
  EXPECT_FALSE(may_create(topic));
}

// An insider without any right must not match them, or the listeners of the application's
// participant would get its samples.
TEST_F(Carriers, AnyGovernance_ClosesThemAndProtectsTheirAnnouncements) {
  use(ProtectionKind::sign);
  ON_CALL(plugin, datareader_sec_attributes)
      .WillByDefault([](auto&&...) -> Result<spi::EndpointSecurityAttributes> {
        return fail(Code::topic_not_allowed);
      });
  DDS_Security_EndpointSecurityAttributes attributes{};
  ASSERT_EQ(
      c->get_datareader_sec_attributes(c, 8, topic.c_str(), nullptr, nullptr, &attributes, nullptr),
      1);
  EXPECT_TRUE(attributes.is_discovery_protected);
  const auto closed = closed_reader_attributes();
  EXPECT_TRUE(attributes.is_submessage_protected);
  EXPECT_EQ(attributes.plugin_endpoint_attributes, closed.plugin_endpoint_attributes);
  EXPECT_EQ(attributes.ac_endpoint_properties._length, closed.ac_endpoint_properties._length);
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);
}

// The host returns the attributes when a reader is gone.
TEST_F(Carriers, ReturnedReaderAttributes_StartALookForThem) {
  const int before = looks_for_ended_readers;
  DDS_Security_EndpointSecurityAttributes attributes{};
  EXPECT_EQ(c->return_datawriter_sec_attributes(c, &attributes, nullptr), 1);
  EXPECT_EQ(looks_for_ended_readers, before);
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);
  EXPECT_EQ(looks_for_ended_readers, before + 1);
}

}  // namespace
}  // namespace ddssec::cyclonedds

// Our cryptography exports this function in the same process.
DDSSEC_EXPORT void ddssec_look_for_ended_readers() { ++looks_for_ended_readers; }
