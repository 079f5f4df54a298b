// Local endpoints that the core would open to unauthorized participants.
#include "plugins/cyclonedds/unguarded_endpoints.hpp"

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "tests/unit/cyclonedds/access_control_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::access_control_adapters {
namespace {

// Cyclone never asks about endpoints of unauthenticated participants.
TEST_F(AccessControlAdapterTest, EndpointThatUnauthenticatedPeersWouldReach_IsRefused) {
  spi::EndpointSecurityAttributes endpoint;
  bool allow_unauthenticated = true;
  ON_CALL(plugin, check_create_datawriter).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(plugin, check_create_datareader).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(plugin, participant_sec_attributes).WillByDefault([&](auto&&...) {
    return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants =
                                                  allow_unauthenticated};
  });
  ON_CALL(plugin, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  ON_CALL(plugin, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  const auto may_write = [&] {
    return c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, &refusal) != 0;
  };
  const auto may_read = [&] {
    Refusal unread;
    return c->check_create_datareader(c, 8, 5, "Square", &qos, nullptr, nullptr, &unread) != 0;
  };
  EXPECT_TRUE(may_write());
  EXPECT_TRUE(may_read());
  endpoint.topic.is_read_protected = true;
  EXPECT_FALSE(may_write());
  EXPECT_EQ(refusal.reason(), Code::unauthenticated_peers_unstoppable);
  EXPECT_TRUE(may_read());
  endpoint.topic.is_write_protected = true;
  EXPECT_FALSE(may_read());
  endpoint.payload = ProtectionKind::encrypt;
  EXPECT_TRUE(may_write());
  EXPECT_TRUE(may_read());
  endpoint.payload = ProtectionKind::none;
  allow_unauthenticated = false;
  Refusal unguarded;
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, &unguarded), 0);
  EXPECT_EQ(unguarded.reason(), Code::controlled_topic_unguarded);
  EXPECT_THAT(harness.events.back().error.to_sentence(), testing::HasSubstr("Square"));
  EXPECT_FALSE(may_read());
  endpoint.submessage = ProtectionKind::sign;
  EXPECT_TRUE(may_write());
  EXPECT_TRUE(may_read());
}

// The core accepts unprotected messages of such a participant, whatever protection governance
// demands.
TEST_F(AccessControlAdapterTest, AReaderThatOnlyMessageProtectionCovers_IsRefusedWithGuests) {
  spi::EndpointSecurityAttributes endpoint;
  spi::ParticipantSecurityAttributes participant{.allow_unauthenticated_participants = true,
                                                 .rtps = ProtectionKind::encrypt};
  ON_CALL(plugin, check_create_datawriter).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(plugin, check_create_datareader).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(plugin, participant_sec_attributes).WillByDefault([&](auto&&...) { return participant; });
  ON_CALL(plugin, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  ON_CALL(plugin, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  const auto may_read = [&] {
    return c->check_create_datareader(c, 8, 5, "Square", &qos, nullptr, nullptr, &refusal) != 0;
  };
  EXPECT_FALSE(may_read());
  EXPECT_EQ(refusal.reason(), Code::unauthenticated_peers_unstoppable);
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, nullptr), 1);
  endpoint.payload = ProtectionKind::sign;
  EXPECT_TRUE(may_read());
  endpoint.payload = ProtectionKind::none;
  participant.allow_unauthenticated_participants = false;
  EXPECT_TRUE(may_read());
}

}  // namespace
}  // namespace ddssec::cyclonedds::access_control_adapters
