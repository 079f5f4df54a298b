#include "plugins/cyclonedds/access_control_adapter.hpp"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "plugins/cyclonedds/match_gate.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "tests/support/code_of.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using test::code_of;
using testing::_;
using testing::Field;
using testing::Return;
using Handle = spi::PermissionsHandle;

/// What make_scope makes of a reader of "Square".
spi::PropertyList scope_of(std::uint64_t adapter) {
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
  MockAccessControl& engine = *harness.engine;
  Refusal refusal;
  DDS_Security_Qos qos{};
  DDS_Security_DataHolder token{};
  std::string topic = "Square";
  DDS_Security_PublicationBuiltinTopicDataSecure publication{};
  DDS_Security_SubscriptionBuiltinTopicDataSecure subscription{};
  DDS_Security_TopicBuiltinTopicData topic_data{};
};

TEST_F(AccessControlAdapterTest, TableIsCompleteAndTheDomainIsInIt) {
  EXPECT_EQ(c->gv, harness.domain());
  const auto* begin = reinterpret_cast<void* const*>(c);
  for (int i = 0; i < 31; ++i) EXPECT_NE(begin[i], nullptr) << i;
}

TEST_F(AccessControlAdapterTest, PermissionsOfBothSides) {
  EXPECT_CALL(engine, validate_local_permissions(spi::IdentityHandle{1}, 5, _, std::string_view()))
      .WillOnce(Return(Handle{8}));
  EXPECT_EQ(c->validate_local_permissions(c, nullptr, 1, 5, &qos, &refusal), 8);
  EXPECT_CALL(engine, validate_remote_permissions(spi::IdentityHandle{1}, spi::IdentityHandle{2},
                                                  sample_token(), sample_token()))
      .WillOnce(Return(Handle{9}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, &token, &token, &refusal), 9);
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, &token, &token, &refusal),
            DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(refusal.reason(), Code::malformed);
}

// A stranger can leave it out of a forged announcement; the host is not to blame.
TEST_F(AccessControlAdapterTest, AnAnnouncement_WithoutPermissionsToken_IsOfAnotherKind) {
  const DDS_Security_Token none{};
  for (const auto* announced : {static_cast<const DDS_Security_Token*>(nullptr), &none}) {
    EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, announced, &token, &refusal), 0);
    EXPECT_EQ(refusal.reason(), Code::permissions_token_class);
    refusal.clear();
  }
}

// Our authentication asks, in another library.
TEST_F(AccessControlAdapterTest, SaysWhatTheGovernanceOfALocalParticipantAllows) {
  constexpr spi::IdentityHandle kOpen{1}, kClosed{2};
  ON_CALL(engine, validate_local_permissions(kOpen, _, _, _)).WillByDefault(Return(Handle{8}));
  ON_CALL(engine, validate_local_permissions(kClosed, _, _, _)).WillByDefault(Return(Handle{9}));
  ON_CALL(engine, participant_sec_attributes).WillByDefault([](Handle handle) {
    return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants =
                                                  handle == Handle{8}};
  });
  for (const auto local : {kOpen, kClosed})
    EXPECT_NE(c->validate_local_permissions(c, nullptr, local.value, 5, &qos, nullptr), 0);
  const auto facts = &AccessControlAdapter::governance_facts_of;
  EXPECT_TRUE(has(facts(kOpen), GovernanceFact::allows_unauthenticated));
  EXPECT_FALSE(has(facts(kClosed), GovernanceFact::allows_unauthenticated));
  EXPECT_EQ(c->return_permissions_handle(c, 8, nullptr), 1);
  EXPECT_EQ(facts(kOpen), 0u);
}

TEST_F(AccessControlAdapterTest, RenewedPermissions_AreTold_OnceForEachRenewal) {
  constexpr spi::IdentityHandle kLocal{1}, kOther{2};
  ON_CALL(engine, validate_local_permissions).WillByDefault(Return(Handle{8}));
  ON_CALL(engine, permissions_credential_token(Handle{8}))
      .WillByDefault(Return(spi::Token{.class_id = "c", .properties = {{"dds.perm.cert", "new"}}}));
  EXPECT_NE(c->validate_local_permissions(c, nullptr, kLocal.value, 5, &qos, nullptr), 0);
  const auto renewed = &AccessControlAdapter::renewed_permissions;
  EXPECT_FALSE(renewed(kLocal, 0));
  ON_CALL(engine, renewals(Handle{8})).WillByDefault(Return(2));
  EXPECT_FALSE(renewed(kOther, 0));
  const auto told = renewed(kLocal, 1);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->times, 2u);
  EXPECT_EQ(told->text, "new");
  EXPECT_FALSE(renewed(kLocal, 2));
  EXPECT_EQ(c->return_permissions_handle(c, 8, nullptr), 1);
  EXPECT_FALSE(renewed(kLocal, 1));
}

TEST_F(AccessControlAdapterTest, ChecksPassTheQuestionAndTheAnswer) {
  EXPECT_CALL(engine, check_create_participant(Handle{8}, 5)).WillOnce(Return(Status{}));
  EXPECT_CALL(engine, check_create_datawriter(Handle{8}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_CALL(engine, check_create_datareader(Handle{8}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(engine, check_create_topic(Handle{8}, 5, "Square")).WillOnce(Return(Status{}));
  EXPECT_CALL(engine, check_remote_participant(Handle{9}, 5)).WillOnce(Return(Status{}));
  EXPECT_CALL(engine, check_remote_datawriter(Handle{9}, 5, asks_for_topic()))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(engine, check_remote_topic(Handle{9}, 5, "Square")).WillOnce(Return(Status{}));

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

// closed_readers.hpp
TEST_F(AccessControlAdapterTest, ClosesTheReadersOfClearDiscoveryAndNoWriter) {
  ON_CALL(engine, participant_sec_attributes).WillByDefault([](Handle) {
    return spi::ParticipantSecurityAttributes{.is_all_discovery_protected = true};
  });
  ON_CALL(engine, datareader_sec_attributes).WillByDefault([](auto&&...) {
    return spi::EndpointSecurityAttributes{};
  });
  ON_CALL(engine, datawriter_sec_attributes).WillByDefault([](auto&&...) {
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

// What access control says of an endpoint, and what cryptography asks with it.
TEST_F(AccessControlAdapterTest, CryptographyAsksAboutTheEndpointItself) {
  spi::EndpointSecurityAttributes endpoint;
  endpoint.topic.is_read_protected = true;
  endpoint.payload = ProtectionKind::encrypt;
  ON_CALL(engine, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  std::string first = "p", second = "q", tag = "colour", value = "red";
  char* names[] = {first.data(), second.data()};
  const DDS_Security_PartitionQosPolicy partition{{2, 2, names}};
  DDS_Security_Tag tag_of_it{tag.data(), value.data()};
  const DDS_Security_DataTags tags{{1, 1, &tag_of_it}};
  DDS_Security_EndpointSecurityAttributes attributes{};
  ASSERT_EQ(
      c->get_datareader_sec_attributes(c, 8, "Square", &partition, &tags, &attributes, nullptr), 1);
  const auto gate = MatchGate::of(attributes.ac_endpoint_properties);
  ASSERT_TRUE(gate && *gate);
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);
  EXPECT_FALSE(is_scope(attributes.ac_endpoint_properties));
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);  // once is enough

  const auto scope = scope_of(harness.adapter.id());
  const MatchGate asks(scope, AccessControlAdapter::judge);
  const GuidPrefix prefix{{1, 2, 3}};
  EXPECT_CALL(engine, check_remote_match(Handle{9}, _))
      .WillOnce([&](Handle, const spi::AccessControl::Match& match) -> Status {
        EXPECT_TRUE(match.remote_writes);
        EXPECT_EQ(match.remote, prefix);
        EXPECT_EQ(match.local.topic_name, "Square");
        EXPECT_EQ(match.local.partitions.size(), 2u);
        EXPECT_EQ(match.local.partitions[1], "q");
        EXPECT_EQ(match.local.data_tags.size(), 1u);
        EXPECT_EQ(match.local.data_tags[0].value, "red");
        return {};
      })
      .WillOnce(Return(fail(Code::match_not_permitted)));
  EXPECT_TRUE(asks.check({{9}, prefix, true}));
  EXPECT_EQ(code_of(asks.check({{9}, {}, false})), Code::keys_not_permitted);
  ASSERT_EQ(harness.events.size(), 1u);
  EXPECT_EQ(harness.events[0].error.code(), Code::match_not_permitted);
}

TEST_F(AccessControlAdapterTest, EachAdapterIsAskedAboutItsOwnAndNoneThatIsGone) {
  std::uint64_t gone = 0;
  {
    Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> other;
    gone = other.adapter.id();
    EXPECT_NE(gone, harness.adapter.id());
    EXPECT_CALL(*other.engine, check_remote_match(_, _));
    EXPECT_CALL(engine, check_remote_match(_, _)).Times(0);
    EXPECT_TRUE(MatchGate(scope_of(gone), AccessControlAdapter::judge).check({}));
  }
  EXPECT_EQ(code_of(MatchGate(scope_of(gone), AccessControlAdapter::judge).check({})),
            Code::access_control_missing);
  auto broken = scope_of(harness.adapter.id());
  broken[0].value += "x";
  EXPECT_EQ(code_of(MatchGate(broken, AccessControlAdapter::judge).check({})),
            Code::access_control_missing);
  EXPECT_EQ(AccessControlAdapter::judge(nullptr), MatchVerdict::unknown_access_control);
  // No library of this process exports it.
  EXPECT_EQ(code_of(MatchGate(scope_of(harness.adapter.id())).check({})),
            Code::access_control_missing);
}

TEST_F(AccessControlAdapterTest, OnlyEndpointsUnderAccessControlHaveAScope) {
  spi::EndpointSecurityAttributes endpoint;
  ON_CALL(engine, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  const auto has_scope = [&] {
    DDS_Security_EndpointSecurityAttributes attributes{};
    EXPECT_EQ(
        c->get_datawriter_sec_attributes(c, 8, "Square", nullptr, nullptr, &attributes, nullptr),
        1);
    const bool has = is_scope(attributes.ac_endpoint_properties);
    EXPECT_EQ(MatchGate::of(attributes.ac_endpoint_properties).value() != nullptr, has);
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

// Cyclone never asks about endpoints of unauthenticated participants.
TEST_F(AccessControlAdapterTest, AnEndpointThatUnauthenticatedPeersWouldReachIsRefused) {
  spi::EndpointSecurityAttributes endpoint;
  bool allow_unauthenticated = true;
  ON_CALL(engine, check_create_datawriter).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(engine, check_create_datareader).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(engine, participant_sec_attributes).WillByDefault([&](auto&&...) {
    return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants =
                                                  allow_unauthenticated};
  });
  ON_CALL(engine, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  ON_CALL(engine, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
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

// The core takes what such a participant sends without protection, whatever governance protects.
TEST_F(AccessControlAdapterTest, AReaderThatOnlyMessageProtectionCoversIsRefusedWithGuests) {
  spi::EndpointSecurityAttributes endpoint;
  spi::ParticipantSecurityAttributes participant{.allow_unauthenticated_participants = true,
                                                 .rtps = ProtectionKind::encrypt};
  ON_CALL(engine, check_create_datawriter).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(engine, check_create_datareader).WillByDefault([](auto&&...) { return Status{}; });
  ON_CALL(engine, participant_sec_attributes).WillByDefault([&](auto&&...) { return participant; });
  ON_CALL(engine, datawriter_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  ON_CALL(engine, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
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

TEST_F(AccessControlAdapterTest, RelayOnlyIsAlwaysSet) {
  EXPECT_CALL(engine, check_remote_datareader(Handle{9}, 5, asks_for_topic()))
      .WillOnce(Return(spi::AccessControl::RemoteDatareader{.relay_only = true}))
      .WillOnce(Return(spi::AccessControl::RemoteDatareader{.relay_only = false}))
      .WillOnce(Return(fail(Code::malformed)));
  DDS_Security_boolean relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &relay_only, nullptr), 1);
  EXPECT_EQ(relay_only, 1);
  relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &relay_only, nullptr), 1);
  EXPECT_EQ(relay_only, 0);
  relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, &subscription, &relay_only, nullptr), 0);
  EXPECT_EQ(relay_only, 0);
  relay_only = 77;
  EXPECT_EQ(c->check_remote_datareader(c, 9, 5, nullptr, &relay_only, nullptr), 0);
  EXPECT_EQ(relay_only, 0);
}

TEST_F(AccessControlAdapterTest, PartitionsAndTagsOfARemoteReachTheEngine) {
  std::string partition = "P", name = "n", value = "v";
  DDS_Security_string partitions[] = {partition.data()};
  publication.partition.name = {1, 1, partitions};
  DDS_Security_Tag tag{name.data(), value.data()};
  publication.data_tags.tags = {1, 1, &tag};
  EXPECT_CALL(engine, check_remote_datawriter)
      .WillOnce([](Handle, DomainId, const spi::EndpointRequest& request) -> Status {
        EXPECT_THAT(request.partitions, testing::ElementsAre("P"));
        EXPECT_EQ(request.data_tags.size(), 1u);
        return {};
      });
  EXPECT_EQ(c->check_remote_datawriter(c, 9, 5, &publication, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, CyclonesLocalBuiltinTopicsMayBeReadAndNothingElseSlipsThrough) {
  EXPECT_CALL(engine, check_create_datareader).Times(4).WillRepeatedly([](auto&&...) -> Status {
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
  EXPECT_CALL(engine, check_create_topic).Times(4).WillRepeatedly([](auto&&...) -> Status {
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

TEST_F(AccessControlAdapterTest, WhatNobodyCallsAllows) {
  EXPECT_EQ(c->check_local_datawriter_register_instance(c, 8, nullptr, nullptr, nullptr), 1);
  EXPECT_EQ(c->check_local_datawriter_dispose_instance(c, 8, nullptr, 0, nullptr), 1);
  EXPECT_EQ(c->check_local_datawriter_match(c, 8, 8, &publication, &subscription, nullptr), 1);
  EXPECT_EQ(c->check_local_datareader_match(c, 8, 8, &subscription, &publication, nullptr), 1);
  EXPECT_EQ(c->check_remote_datawriter_register_instance(c, 9, nullptr, 0, 0, 0, nullptr), 1);
  EXPECT_EQ(c->check_remote_datawriter_dispose_instance(c, 9, nullptr, 0, 0, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, TokensAreMadeAndReturnedTwice) {
  ON_CALL(engine, permissions_token).WillByDefault(Return(sample_token()));
  ON_CALL(engine, permissions_credential_token).WillByDefault(Return(sample_token()));
  DDS_Security_DataHolder made{};
  ASSERT_EQ(c->get_permissions_token(c, &made, 8, nullptr), 1);
  EXPECT_EQ(*token_from(&made), sample_token());
  EXPECT_EQ(c->return_permissions_token(c, &made, nullptr), 1);
  EXPECT_EQ(c->return_permissions_token(c, &made, nullptr), 1);
  ASSERT_EQ(c->get_permissions_credential_token(c, &made, 8, nullptr), 1);
  EXPECT_EQ(c->return_permissions_credential_token(c, &made, nullptr), 1);
}

TEST_F(AccessControlAdapterTest, AttributesCarryMasksAndNoProperties) {
  ON_CALL(engine, participant_sec_attributes)
      .WillByDefault(Return(spi::ParticipantSecurityAttributes{
          .rtps = spi::ProtectionKind::encrypt_with_origin_authentication}));
  ON_CALL(engine, topic_sec_attributes)
      .WillByDefault(Return(spi::TopicSecurityAttributes{.is_write_protected = true}));
  const spi::EndpointSecurityAttributes endpoint{.topic = {},
                                                 .payload = spi::ProtectionKind::encrypt};
  ON_CALL(engine, datawriter_sec_attributes).WillByDefault(Return(endpoint));
  ON_CALL(engine, datareader_sec_attributes).WillByDefault(Return(endpoint));

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

TEST_F(AccessControlAdapterTest, NullArgumentsAreRefusedNotFollowed) {
  EXPECT_EQ(c->validate_local_permissions(c, nullptr, 1, 5, nullptr, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
  EXPECT_EQ(c->validate_remote_permissions(c, nullptr, 1, 2, nullptr, &token, nullptr), 0);
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

TEST_F(AccessControlAdapterTest, AnEngineThatThrowsDenies) {
  ON_CALL(engine, check_create_participant).WillByDefault(testing::Throw(std::logic_error("x")));
  EXPECT_EQ(c->check_create_participant(c, 8, 5, &qos, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::internal);
}

TEST_F(AccessControlAdapterTest, PermissionsAreReturned) {
  EXPECT_CALL(engine, return_permissions_handle(Handle{9}))
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_EQ(c->return_permissions_handle(c, 0, nullptr), 1);
  EXPECT_EQ(c->return_permissions_handle(c, 9, nullptr), 1);
  EXPECT_EQ(c->return_permissions_handle(c, 9, nullptr), 0);
}

std::atomic<DDS_Security_PermissionsHandle> revoked_permissions{0};

TEST_F(AccessControlAdapterTest, ExpiredPermissionsAreRevokedThroughTheListener) {
  ON_CALL(engine, expire).WillByDefault(Return(std::vector<Handle>{{41}}));
  ON_CALL(engine, next_expiry).WillByDefault(Return(std::nullopt));
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
}  // namespace ddssec::cyclonedds
