#include "plugins/cyclonedds/access_control_adapter.hpp"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "plugins/cyclonedds/access_control_gate.hpp"
#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/unit/cyclonedds/access_control_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::access_control_adapters {
namespace {

using testing::_;
using testing::Return;

using Handle = spi::PermissionsHandle;

TEST_F(AccessControlAdapterTest, Table_IsCompleteAndTheDomainIsInIt) {
  EXPECT_EQ(c->gv, harness.domain());
  const auto* begin = reinterpret_cast<void* const*>(c);
  for (int i = 0; i < 31; ++i) EXPECT_NE(begin[i], nullptr) << i;
}

TEST_F(AccessControlAdapterTest, PermissionsOfBothSides_ReachThePlugin) {
  EXPECT_CALL(plugin, validate_local_permissions(spi::IdentityHandle{1}, 5, _, std::string_view()))
      .WillOnce(Return(Handle{8}));
  EXPECT_EQ(c->validate_local_permissions(c, nullptr, 1, 5, &qos, &refusal), 8);
  EXPECT_CALL(plugin, validate_remote_permissions(spi::IdentityHandle{1}, spi::IdentityHandle{2}, _,
                                                  sample_token()))
      .WillOnce(Return(Handle{9}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, &token, &token, &refusal), 9);
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, &token, &token, &refusal),
            DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(refusal.reason(), Code::malformed);
}

// A stranger can leave the token out of a forged announcement, or give it another class.
TEST_F(AccessControlAdapterTest, AnnouncedPermissionsToken_IsNotUsed) {
  const spi::Token of_our_class{.class_id = std::string(spi::class_id::kPermissions)};
  EXPECT_CALL(plugin, validate_remote_permissions(_, _, of_our_class, sample_token()))
      .Times(3)
      .WillRepeatedly(Return(Handle{9}));
  const DDS_Security_Token none{};
  for (const auto* announced : {static_cast<const DDS_Security_Token*>(nullptr), &none,
                                static_cast<const DDS_Security_Token*>(&token)})
    EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, announced, &token, &refusal), 9);
}

TEST_F(AccessControlAdapterTest, EachCheck_PassesTheQuestionAndTheAnswer) {
  EXPECT_CALL(plugin, check_create_participant(Handle{8}, 5)).WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, check_create_datawriter(Handle{8}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_CALL(plugin, check_create_datareader(Handle{8}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, check_create_topic(Handle{8}, 5, "Square")).WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, check_remote_participant(Handle{9}, 5)).WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, check_remote_datawriter(Handle{9}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, check_remote_topic(Handle{9}, 5, "Square")).WillOnce(Return(Status{}));

  EXPECT_EQ(c->check_create_participant(c, 8, 5, &qos, nullptr), 1);
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, nullptr), 1);
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::malformed);
  EXPECT_EQ(c->check_create_datareader(c, 8, 5, "Square", &qos, nullptr, nullptr, nullptr), 1);
  EXPECT_EQ(c->check_create_topic(c, 8, 5, "Square", &qos, nullptr), 1);
  EXPECT_EQ(c->check_remote_participant(c, 9, 5, nullptr, nullptr), 1);
  EXPECT_EQ(c->check_remote_datawriter(c, 9, 5, &publication, nullptr), 1);
  EXPECT_EQ(c->check_remote_topic(c, 9, 5, &topic_data, nullptr), 1);
}

// closed_readers.hpp says which readers are closed.
TEST_F(AccessControlAdapterTest, ClearDiscovery_ClosesItsReadersAndNoWriter) {
  ON_CALL(plugin, participant_sec_attributes).WillByDefault([](Handle) {
    return spi::ParticipantSecurityAttributes{.is_all_discovery_protected = true};
  });
  ON_CALL(plugin, datareader_sec_attributes).WillByDefault([](auto&&...) {
    return spi::EndpointSecurityAttributes{};
  });
  ON_CALL(plugin, datawriter_sec_attributes).WillByDefault([](auto&&...) {
    return spi::EndpointSecurityAttributes{};
  });
  DDS_Security_EndpointSecurityAttributes reader{}, writer{}, other{};
  constexpr auto* kTopic = "DCPSPublication";
  ASSERT_EQ(c->get_datareader_sec_attributes(c, 8, kTopic, nullptr, nullptr, &reader, nullptr), 1);
  ASSERT_EQ(c->get_datawriter_sec_attributes(c, 8, kTopic, nullptr, nullptr, &writer, nullptr), 1);
  ASSERT_EQ(
      c->get_datareader_sec_attributes(c, 8, "DCPSParticipant", nullptr, nullptr, &other, nullptr),
      1);
  EXPECT_TRUE(reader.is_submessage_protected);
  EXPECT_FALSE(writer.is_submessage_protected);
  EXPECT_FALSE(other.is_submessage_protected);
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &reader, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, OnlyEndpointsUnderAccessControl_HaveAScope) {
  spi::EndpointSecurityAttributes endpoint;
  ON_CALL(plugin, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  const auto has_scope = [&] {
    DDS_Security_EndpointSecurityAttributes attributes{};
    EXPECT_EQ(
        c->get_datawriter_sec_attributes(c, 8, "Square", nullptr, nullptr, &attributes, nullptr),
        1);
    const bool has = is_scope(attributes.ac_endpoint_properties);
    EXPECT_EQ(AccessControlGate::of(attributes.ac_endpoint_properties).value() != nullptr, has);
    EXPECT_EQ(c->return_datawriter_sec_attributes(c, &attributes, nullptr), 1);
    return has;
  };
  EXPECT_FALSE(has_scope());
  endpoint.payload = ProtectionKind::sign;
  EXPECT_FALSE(has_scope());
  endpoint.topic.is_write_protected = true;
  EXPECT_TRUE(has_scope());
  endpoint.is_builtin = true;
  EXPECT_FALSE(has_scope());
}

TEST_F(AccessControlAdapterTest, RelayOnly_IsAlwaysSet) {
  EXPECT_CALL(plugin, check_remote_datareader(Handle{9}, 5, asks_for_topic()))
      .WillOnce(Return(spi::AccessControl::RemoteDatareader{.is_relay_only = true}))
      .WillOnce(Return(spi::AccessControl::RemoteDatareader{.is_relay_only = false}))
      .WillOnce(Return(fail(Code::malformed)));
  DDS_Security_boolean is_relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &is_relay_only, nullptr), 1);
  EXPECT_EQ(is_relay_only, 1);
  is_relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &is_relay_only, nullptr), 1);
  EXPECT_EQ(is_relay_only, 0);
  is_relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &is_relay_only, nullptr), 0);
  EXPECT_EQ(is_relay_only, 0);
  is_relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, nullptr, &is_relay_only, nullptr), 0);
  EXPECT_EQ(is_relay_only, 0);
}

TEST_F(AccessControlAdapterTest, PartitionsAndTagsOfARemote_ReachThePlugin) {
  std::string partition = "P", name = "n", value = "v";
  DDS_Security_string partitions[] = {partition.data()};
  publication.partition.name = {1, 1, partitions};
  DDS_Security_Tag tag{name.data(), value.data()};
  publication.data_tags.tags = {1, 1, &tag};
  EXPECT_CALL(plugin, check_remote_datawriter)
      .WillOnce([](Handle, DomainId, const spi::EndpointRequest& request) -> Status {
        EXPECT_THAT(request.partitions, testing::ElementsAre("P"));
        EXPECT_EQ(request.data_tags.size(), 1u);
        return {};
      });
  EXPECT_EQ(c->check_remote_datawriter(c, 9, 5, &publication, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, CyclonesLocalBuiltinTopics_MayBeReadAndNothingElseSlipsThrough) {
  EXPECT_CALL(plugin, check_create_datareader).Times(4).WillRepeatedly([](auto&&...) -> Status {
    return fail(Code::malformed);
  });
  std::string builtin = "__BUILT-IN PARTITION__", other = "P";
  const auto may_read = [&](const char* name, std::vector<DDS_Security_string> partitions) {
    const auto count = static_cast<DDS_Security_unsigned_long>(partitions.size());
    const DDS_Security_PartitionQosPolicy partition{{count, count, partitions.data()}};
    return c->check_create_datareader(c, 8, 5, name, &qos, &partition, nullptr, nullptr) != 0;
  };
  for (const auto* name : {"DCPSParticipant", "DCPSTopic", "DCPSPublication", "DCPSSubscription"})
    EXPECT_TRUE(may_read(name, {builtin.data()})) << name;
  EXPECT_FALSE(may_read("DCPSParticipant", {}));
  EXPECT_FALSE(may_read("DCPSParticipant", {other.data()}));
  EXPECT_FALSE(may_read("DCPSParticipant", {builtin.data(), other.data()}));
  EXPECT_FALSE(may_read("Square", {builtin.data()}));
}

TEST_F(AccessControlAdapterTest, CyclonesLocalBuiltinTopics_DefaultDeny_AreCreatedAndNoOthers) {
  EXPECT_CALL(plugin, check_create_topic).Times(4).WillRepeatedly([](auto&&...) -> Status {
    return fail(Code::topic_not_allowed);
  });
  const auto may_create = [&](const char* name) {
    return c->check_create_topic(c, 8, 5, name, &qos, nullptr) != 0;
  };
  for (const auto* name : {"DCPSParticipant", "DCPSTopic", "DCPSPublication", "DCPSSubscription"})
    EXPECT_TRUE(may_create(name)) << name;
  for (const auto* name : {"Square", "DCPS", "DCPSParticipantX", "dcpsparticipant"})
    EXPECT_FALSE(may_create(name)) << name;
}

TEST_F(AccessControlAdapterTest, ChecksThatTheHostNeverCalls_Allow) {
  EXPECT_EQ(c->check_local_datawriter_register_instance(c, 8, nullptr, nullptr, nullptr), 1);
  EXPECT_EQ(c->check_local_datawriter_dispose_instance(c, 8, nullptr, 0, nullptr), 1);
  EXPECT_EQ(c->check_local_datawriter_match(c, 8, 8, &publication, &subscription, nullptr), 1);
  EXPECT_EQ(c->check_local_datareader_match(c, 8, 8, &subscription, &publication, nullptr), 1);
  EXPECT_EQ(c->check_remote_datawriter_register_instance(c, 9, nullptr, 0, 0, 0, nullptr), 1);
  EXPECT_EQ(c->check_remote_datawriter_dispose_instance(c, 9, nullptr, 0, 0, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, Tokens_AreMadeAndReturnedTwice) {
  ON_CALL(plugin, permissions_token).WillByDefault(Return(sample_token()));
  ON_CALL(plugin, permissions_credential_token).WillByDefault(Return(sample_token()));
  DDS_Security_DataHolder made{};
  ASSERT_EQ(c->get_permissions_token(c, &made, 8, nullptr), 1);
  EXPECT_EQ(*token_from(&made), sample_token());
  EXPECT_EQ(c->return_permissions_token(c, &made, nullptr), 1);
  EXPECT_EQ(c->return_permissions_token(c, &made, nullptr), 1);
  ASSERT_EQ(c->get_permissions_credential_token(c, &made, 8, nullptr), 1);
  EXPECT_EQ(c->return_permissions_credential_token(c, &made, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, Attributes_CarryMasksAndNoProperties) {
  ON_CALL(plugin, participant_sec_attributes)
      .WillByDefault(Return(spi::ParticipantSecurityAttributes{
          .rtps = spi::ProtectionKind::encrypt_with_origin_authentication}));
  ON_CALL(plugin, topic_sec_attributes)
      .WillByDefault(Return(spi::TopicSecurityAttributes{.is_write_protected = true}));
  const spi::EndpointSecurityAttributes endpoint{.topic = {},
                                                 .payload = spi::ProtectionKind::encrypt};
  ON_CALL(plugin, datawriter_sec_attributes).WillByDefault(Return(endpoint));
  ON_CALL(plugin, datareader_sec_attributes).WillByDefault(Return(endpoint));

  DDS_Security_ParticipantSecurityAttributes p{};
  ASSERT_EQ(c->get_participant_sec_attributes(c, 8, &p, nullptr), 1);
  EXPECT_EQ(p.plugin_participant_attributes,
            spi::kMaskIsValid | DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_RTPS_ENCRYPTED |
                DDS_SECURITY_PLUGIN_PARTICIPANT_ATTRIBUTES_FLAG_IS_RTPS_AUTHENTICATED);
  EXPECT_EQ(c->return_participant_sec_attributes(c, &p, nullptr), 1);
  DDS_Security_TopicSecurityAttributes t{};
  ASSERT_EQ(c->get_topic_sec_attributes(c, 8, "Square", &t, nullptr), 1);
  EXPECT_EQ(t.is_write_protected, 1);
  EXPECT_EQ(c->return_topic_sec_attributes(c, &t, nullptr), 1);
  for (const auto get : {c->get_datawriter_sec_attributes, c->get_datareader_sec_attributes}) {
    DDS_Security_EndpointSecurityAttributes e{};
    ASSERT_EQ(get(c, 8, "Square", nullptr, nullptr, &e, nullptr), 1);
    EXPECT_EQ(
        e.plugin_endpoint_attributes,
        spi::kMaskIsValid | DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_PAYLOAD_ENCRYPTED);
    EXPECT_EQ(e.ac_endpoint_properties._buffer, nullptr);
    EXPECT_EQ(c->return_datawriter_sec_attributes(c, &e, nullptr), 1);
    EXPECT_EQ(c->return_datareader_sec_attributes(c, &e, nullptr), 1);
  }
}

// In the core of version 0.10.2 a failed handshake of the one ends the process by one of the other.
TEST_F(AccessControlAdapterTest,
       ParticipantThatAdmitsUnauthenticatedOnes_IsAloneInItsDomainOfTheProcess) {
  bool admits = false;
  ON_CALL(plugin, participant_sec_attributes).WillByDefault([&](Handle) {
    return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants = admits};
  });
  ON_CALL(plugin, return_permissions_handle).WillByDefault(Return(Status{}));
  const auto create = [&](std::int64_t local, bool its_governance_admits) {
    admits = its_governance_admits;
    ON_CALL(plugin, validate_local_permissions).WillByDefault(Return(Handle{local}));
    EXPECT_EQ(c->validate_local_permissions(c, nullptr, local, 5, &qos, nullptr), local);
    DDS_Security_ParticipantSecurityAttributes attributes{};
    refusal.clear();
    const bool is_created = c->get_participant_sec_attributes(c, local, &attributes, &refusal);
    EXPECT_EQ(attributes.allow_unauthenticated_participants, is_created && its_governance_admits);
    return is_created;
  };
  EXPECT_TRUE(create(1, false));
  EXPECT_FALSE(create(2, true));
  EXPECT_EQ(refusal.reason(), Code::unauthenticated_peers_need_own_process);
  EXPECT_TRUE(create(3, false)) << "the one that was not created does not count";
  for (const auto local : {1, 3}) EXPECT_EQ(c->return_permissions_handle(c, local, nullptr), 1);
  EXPECT_TRUE(create(4, true));
  EXPECT_FALSE(create(5, false));
  EXPECT_FALSE(create(6, true));
  EXPECT_EQ(c->return_permissions_handle(c, 4, nullptr), 1);
  EXPECT_TRUE(create(7, true));
}

TEST(GovernanceFactsTest, ParticipantThatTheHostDeletes_KeepsNoOtherOut) {
  using namespace std::chrono_literals;
  GovernanceFacts facts;
  for (const std::int64_t local : {1, 2})
    facts.note(Handle{local}, {local}, {.allow_unauthenticated_participants = true});
  EXPECT_TRUE(facts.join(Handle{1}, 10s, false));
  EXPECT_FALSE(facts.join(Handle{2}, 20s, false)) << "the host shows a participant";
  EXPECT_FALSE(facts.join(Handle{2}, 10900ms, true)) << "it may still be creating the first";
  EXPECT_TRUE(facts.join(Handle{2}, 11s, true));
  facts.forget(Handle{1});
  EXPECT_TRUE(facts.join(Handle{2}, 12s, false)) << "it is alone";
}

TEST_F(AccessControlAdapterTest, NullArguments_AreRefusedNotFollowed) {
  EXPECT_EQ(c->validate_local_permissions(c, nullptr, 1, 5, nullptr, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, &token, nullptr, nullptr), 0);
  EXPECT_EQ(c->check_create_datawriter(c, 8, 5, nullptr, &qos, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(c->check_create_datareader(c, 8, 5, nullptr, &qos, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(c->check_create_topic(c, 8, 5, nullptr, &qos, nullptr), 0);
  EXPECT_EQ(c->check_remote_datawriter(c, 9, 5, nullptr, nullptr), 0);
  publication.topic_name = nullptr;
  EXPECT_EQ(c->check_remote_datawriter(c, 9, 5, &publication, nullptr), 0);
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, nullptr, nullptr), 0);
  EXPECT_EQ(c->check_remote_topic(c, 9, 5, nullptr, nullptr), 0);
  EXPECT_EQ(c->get_permissions_token(c, nullptr, 8, nullptr), 0);
  EXPECT_EQ(c->get_permissions_credential_token(c, nullptr, 8, nullptr), 0);
  EXPECT_EQ(c->get_participant_sec_attributes(c, 8, nullptr, nullptr), 0);
  EXPECT_EQ(c->get_topic_sec_attributes(c, 8, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(c->get_datawriter_sec_attributes(c, 8, "T", nullptr, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(c->check_create_participant(nullptr, 8, 5, &qos, nullptr), 0);
}

TEST_F(AccessControlAdapterTest, PluginThatThrows_Denies) {
  ON_CALL(plugin, check_create_participant).WillByDefault(testing::Throw(std::logic_error("x")));
  EXPECT_EQ(c->check_create_participant(c, 8, 5, &qos, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::internal);
}

TEST_F(AccessControlAdapterTest, Permissions_AreReturned) {
  EXPECT_CALL(plugin, return_permissions_handle(Handle{9}))
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_EQ(c->return_permissions_handle(c, 0, nullptr), 1);
  EXPECT_EQ(c->return_permissions_handle(c, 9, nullptr), 1);
  EXPECT_EQ(c->return_permissions_handle(c, 9, nullptr), 0);
}

std::atomic<DDS_Security_PermissionsHandle> revoked_permissions{0};

TEST_F(AccessControlAdapterTest, ExpiredPermissions_AreRevokedThroughTheListener) {
  ON_CALL(plugin, poll).WillByDefault(Return(std::vector<Handle>{{41}}));
  ON_CALL(plugin, next_expiry).WillByDefault(Return(std::nullopt));
  const dds_security_access_control_listener listener{
      [](const dds_security_access_control*,
         const DDS_Security_PermissionsHandle handle) -> DDS_Security_boolean {
        revoked_permissions = handle;
        return 1;
      }};
  EXPECT_EQ(c->set_listener(c, &listener, nullptr), 1);
  for (int i = 0; i < 1000 && revoked_permissions == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(revoked_permissions, 41);
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
}

}  // namespace
}  // namespace ddssec::cyclonedds::access_control_adapters
