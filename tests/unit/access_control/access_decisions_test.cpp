#include "plugins/access_control/access_decisions.hpp"

#include "tests/unit/access_control/access_control_fixture.hpp"
#include "tests/unit/access_control/decisions.hpp"

namespace ddssec::access_control {
namespace {

using spi::EndpointRequest;

TEST_F(Decisions, Joining_NeedsAnAllowRuleOfTheDomain) {
  EXPECT_TRUE(plugin->check_create_participant(with({rule(true)}), 0));
  auto elsewhere = rule(true);
  elsewhere.domains.ranges = {{1, 1}};
  EXPECT_REFUSED(plugin->check_create_participant(with({elsewhere}), 0), participant_not_allowed);
  EXPECT_REFUSED(plugin->check_create_participant(with({rule(false), rule(true)}), 0),
                 participant_not_allowed);
  EXPECT_TRUE(plugin->check_create_participant(with({}, true), 0));
  governance_document.domain_rules[0].enable_join_access_control = false;
  EXPECT_TRUE(plugin->check_create_participant(with({elsewhere}), 0));
}

TEST_F(Decisions, PeersJoining_IsDecidedByTheirOwnPermissions) {
  EXPECT_TRUE(plugin->check_remote_participant(peer_with({rule(true)}), 0));
  EXPECT_REFUSED(plugin->check_remote_participant(peer_with({}), 0), participant_not_allowed);
}

TEST_F(Decisions, WritersAndReaders_AreJudgedApart) {
  const auto handle =
      with({publish_rule(true, {"closed_out"}), subscribe_rule(true, {"closed_in"})});
  EXPECT_TRUE(plugin->check_create_datawriter(handle, 0, {.topic_name = "closed_out"}));
  EXPECT_TRUE(plugin->check_create_datareader(handle, 0, {.topic_name = "closed_in"}));
  EXPECT_REFUSED(plugin->check_create_datawriter(handle, 0, {.topic_name = "closed_in"}),
                 publish_not_allowed);
  EXPECT_REFUSED(plugin->check_create_datareader(handle, 0, {.topic_name = "closed_out"}),
                 subscribe_not_allowed);
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "closed_in"));
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "closed_out"));
  EXPECT_REFUSED(plugin->check_create_topic(handle, 0, "closed_other"), topic_not_allowed);
}

TEST_F(Decisions, TopicsWithoutAccessControl_AreOpenToEveryParticipant) {
  const auto handle = with({rule(true)});
  EXPECT_TRUE(plugin->check_create_datawriter(handle, 0, {.topic_name = "open"}));
  EXPECT_TRUE(plugin->check_create_datareader(handle, 0, {.topic_name = "open"}));
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "open"));
  EXPECT_REFUSED(plugin->check_create_datawriter(handle, 0, {.topic_name = "written"}),
                 publish_not_allowed);
  EXPECT_TRUE(plugin->check_create_datareader(handle, 0, {.topic_name = "written"}));
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "written"));
}

TEST_F(Decisions, TopicWithoutRule_IsRefusedEverywhere) {
  const auto handle = with({rule(true)}, true);
  const EndpointRequest request{.topic_name = "unheard"};
  EXPECT_REFUSED(plugin->check_create_datawriter(handle, 0, request), topic_not_covered);
  EXPECT_REFUSED(plugin->check_create_datareader(handle, 0, request), topic_not_covered);
  EXPECT_REFUSED(plugin->check_create_topic(handle, 0, "unheard"), topic_not_covered);
  EXPECT_REFUSED(plugin->datawriter_sec_attributes(handle, request), topic_not_covered);
  EXPECT_REFUSED(plugin->datareader_sec_attributes(handle, request), topic_not_covered);
  EXPECT_REFUSED(plugin->topic_sec_attributes(handle, "unheard"), topic_not_covered);
}

TEST_F(Decisions, Peers_AreJudgedByLocalGovernanceAndTheirPermissions) {
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  EXPECT_TRUE(plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed_out"}));
  EXPECT_TRUE(plugin->check_remote_topic(peer, 0, "closed_out"));
  EXPECT_TRUE(plugin->check_remote_datareader(peer, 0, {.topic_name = "open"}));
  EXPECT_REFUSED(plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed_in"}),
                 announced_writer_not_allowed);
  EXPECT_REFUSED(plugin->check_remote_datareader(peer, 0, {.topic_name = "closed_out"}),
                 announced_reader_not_allowed);
  EXPECT_REFUSED(plugin->check_remote_datawriter(peer, 0, {.topic_name = "unheard"}),
                 topic_not_covered);
}

// A peer is judged by its partitions, too (vulnerability RVD#447).
TEST_F(Decisions, PartitionsAndTagsOfPeers_Count) {
  auto allowed = publish_rule(true, {"closed"});
  allowed.publish[0].partitions = {{{"p", 0}}};
  allowed.publish[0].data_tags = {{{"colour", "red"}}};
  const auto peer = peer_with({allowed});
  const Partitions right = {"p"}, wrong = {"q"}, both = {"p", "q"};
  const std::vector<spi::Property> red = {{"colour", "red"}}, blue = {{"colour", "blue"}};
  const auto check = [&](const Partitions& partitions, const std::vector<spi::Property>& tags) {
    return plugin->check_remote_datawriter(
        peer, 0, {.topic_name = "closed", .partitions = partitions, .data_tags = tags});
  };
  EXPECT_TRUE(check(right, {}));
  EXPECT_TRUE(check(right, red));
  EXPECT_REFUSED(check(wrong, {}), announced_writer_not_allowed);
  EXPECT_REFUSED(check(both, {}), announced_writer_not_allowed);
  EXPECT_REFUSED(check({}, {}), announced_writer_not_allowed);
  EXPECT_REFUSED(check(right, blue), announced_writer_not_allowed);
  make({.one_partition_suffices = true});
  local_ = {};
  const auto legacy = peer_with({allowed});
  EXPECT_TRUE(
      plugin->check_remote_datawriter(legacy, 0, {.topic_name = "closed", .partitions = both}));
}

// An event says whether the application gets the error too, so that a program that prints both can
// print each refusal once.
TEST_F(Decisions, AnEvent_SaysWhetherTheApplicationGetsTheErrorToo) {
  const auto expect_returned = [&](bool is_returned, const auto& refused) {
    EXPECT_FALSE(refused);
    ASSERT_EQ(log.all.size(), 1u);
    EXPECT_EQ(log.all[0].is_returned, is_returned);
    log.all.clear();
  };
  const EndpointRequest denied{.topic_name = "closed"}, unheard{.topic_name = "unheard"};
  const auto own = with({publish_rule(true, {"closed_out"})});
  expect_returned(true, plugin->check_create_datawriter(own, 0, denied));
  expect_returned(true, plugin->check_create_topic(own, 0, "unheard"));
  expect_returned(true, plugin->datareader_sec_attributes(own, unheard));
  expect_returned(true, plugin->check_create_participant(own, 1));
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  expect_returned(false, plugin->check_remote_datawriter(peer, 0, denied));
  expect_returned(false, plugin->check_remote_match(peer, match({.topic_name = "closed"})));
}

TEST_F(Decisions, AMatch_IsJudgedWhetherOrNotTheHostAskedBefore) {
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "closed_out"})));
  log.all.clear();
  const auto refused = plugin->check_remote_match(peer, match({.topic_name = "closed_in"}));
  EXPECT_CODE(refused, match_not_permitted);
  ASSERT_EQ(log.all.size(), 1u);
  const auto& event = log.all[0];
  EXPECT_EQ(event.peer_subject, kListener);
  EXPECT_EQ(event.guid, "810102030405060708090a0b.000001c1");
  const auto& details = event.error.details();
  EXPECT_EQ(details.expected, "an allow_rule to publish topic \"closed_in\"");
  EXPECT_EQ(details.document, refused.error().details().document);
  EXPECT_GT(details.line, 0);
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "closed_out"}, false)),
                 match_not_permitted);
  // A topic without access control is open to all, and all may read a topic with write control
  // only.
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "open"})));
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "written"}, false)));
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "written"})),
                 match_not_permitted);
  EXPECT_TRUE(plugin->return_permissions_handle(peer));
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "closed_out"})),
                 unknown_permissions_handle);
}

TEST_F(Decisions, AMatch_IsJudgedByOurPartitionsUnlessThePeerAnnouncedOthersThatOverlapThem) {
  auto allowed = publish_rule(true, {"closed"});
  allowed.publish[0].partitions = {{{"p", 0}}};
  const auto peer = peer_with({allowed});
  const Partitions p = {"p"}, q = {"q"}, both = {"p", "q"}, all = {"*"};
  const auto may = [&](const Partitions& ours) {
    return plugin->check_remote_match(peer, match({.topic_name = "closed", .partitions = ours}));
  };
  const auto announce = [&](const Partitions& theirs) {
    return plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed", .partitions = theirs});
  };
  EXPECT_TRUE(may(p));
  for (const auto& ours : {q, both, all, Partitions{}})
    EXPECT_REFUSED(may(ours), match_not_permitted);
  // The plugin does not remember such an announcement.
  EXPECT_REFUSED(announce(both), announced_writer_not_allowed);
  EXPECT_REFUSED(may(both), match_not_permitted);
  EXPECT_TRUE(announce(p));
  EXPECT_TRUE(may(both));
  EXPECT_TRUE(may(all));
  EXPECT_REFUSED(may(q), match_not_permitted);
  EXPECT_REFUSED(may({}), match_not_permitted);
  clock.set(kNow + 25h);  // not longer than the grant, either
  EXPECT_REFUSED(may(both), match_not_permitted);
}

TEST_F(Decisions, Relays_AreLetInOnlyIfAsked) {
  auto relay = rule(true);
  relay.relay = {topics({"closed_relay"})};
  const EndpointRequest request{.topic_name = "closed_relay"};
  EXPECT_REFUSED(plugin->check_remote_datareader(peer_with({relay}), 0, request),
                 announced_reader_not_allowed);
  make({.accept_relays = true});
  local_ = {};
  const auto relayed = plugin->check_remote_datareader(peer_with({relay}), 0, request);
  ASSERT_TRUE(relayed);
  EXPECT_TRUE(relayed->is_relay_only);
  relay.subscribe = {topics({"closed_relay"})};
  const auto reader = plugin->check_remote_datareader(peer_with({relay}), 0, request);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->is_relay_only);
  // The default of the permissions makes no relay.
  const auto denied = peer_with({subscribe_rule(false, {"closed_relay"})}, true);
  EXPECT_REFUSED(plugin->check_remote_datareader(denied, 0, request), announced_reader_not_allowed);
}

TEST_F(Decisions, Attributes_AreAsTheDocumentSays) {
  auto& domain_rule = governance_document.domain_rules[0];
  domain_rule.allow_unauthenticated_participants = true;
  domain_rule.discovery_protection_kind = ProtectionKind::encrypt;
  domain_rule.liveliness_protection_kind = ProtectionKind::sign;
  domain_rule.rtps_protection_kind = ProtectionKind::sign_with_origin_authentication;
  domain_rule.topic_rules.insert(domain_rule.topic_rules.begin(),
                                 {.topic_expression = "mixed",
                                  .enable_discovery_protection = false,
                                  .enable_liveliness_protection = true,
                                  .enable_read_access_control = false,
                                  .enable_write_access_control = true,
                                  .metadata_protection_kind = ProtectionKind::sign,
                                  .data_protection_kind = ProtectionKind::none});
  const auto handle = with({rule(true)});
  const auto participant = plugin->participant_sec_attributes(handle);
  ASSERT_TRUE(participant);
  EXPECT_EQ(*participant, (spi::ParticipantSecurityAttributes{
                              true, true, ProtectionKind::sign_with_origin_authentication,
                              ProtectionKind::encrypt, ProtectionKind::sign}));
  const spi::TopicSecurityAttributes topic{false, true, false, true};
  EXPECT_EQ(plugin->topic_sec_attributes(handle, "mixed"), topic);
  const spi::EndpointSecurityAttributes endpoint{topic, ProtectionKind::sign, ProtectionKind::none};
  EXPECT_EQ(plugin->datawriter_sec_attributes(handle, {.topic_name = "mixed"}), endpoint);
  EXPECT_EQ(plugin->datareader_sec_attributes(handle, {.topic_name = "mixed"}), endpoint);
}

TEST_F(Decisions, BuiltinSecureTopics_HaveAttributes) {
  governance_document.domain_rules[0].discovery_protection_kind = ProtectionKind::sign;
  governance_document.domain_rules[0].liveliness_protection_kind =
      ProtectionKind::encrypt_with_origin_authentication;
  const auto handle = with({rule(true)});
  const auto submessage = [&](std::string_view topic) {
    const auto attributes = plugin->datawriter_sec_attributes(handle, {.topic_name = topic});
    EXPECT_TRUE(attributes);
    EXPECT_EQ(attributes->topic, spi::TopicSecurityAttributes{});
    EXPECT_FALSE(attributes->is_payload_protected());
    EXPECT_EQ(plugin->datareader_sec_attributes(handle, {.topic_name = topic}).value(),
              *attributes);
    return attributes->submessage;
  };
  for (const auto* name : {"DCPSParticipantSecure", "DCPSParticipantsSecure",
                           "DCPSPublicationsSecure", "DCPSSubscriptionsSecure"}) {
    EXPECT_EQ(submessage(name), ProtectionKind::sign) << name;
  }
  EXPECT_EQ(submessage("DCPSParticipantMessageSecure"),
            ProtectionKind::encrypt_with_origin_authentication);
  for (const auto* name : {"DCPSParticipant", "DCPSPublication", "DCPSSubscription", "DCPSTopic",
                           "DCPSParticipantMessage", "DCPSTypeLookupRequest", "DCPSTypeLookupReply",
                           "DCPSParticipantStatelessMessage"})
    EXPECT_EQ(submessage(name), ProtectionKind::none) << name;
  EXPECT_EQ(submessage("DCPSParticipantVolatileMessageSecure"), ProtectionKind::encrypt);
  EXPECT_REFUSED(plugin->datawriter_sec_attributes(handle, {.topic_name = "DCPSMine"}),
                 topic_not_covered);
}

// An endpoint that is announced in one partition does not stand for a hidden endpoint in another
// one.
TEST_F(Decisions, PeerThatHidesEndpoints_IsJudgedInOurPartitions) {
  auto allowed = publish_rule(true, {"closed"});
  allowed.publish[0].partitions = {{{"p", 0}}};
  const auto peer = peer_with({allowed});
  const Partitions p = {"p"}, all = {"*"};
  EXPECT_TRUE(plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed", .partitions = p}));
  auto question = match({.topic_name = "closed", .partitions = all});
  EXPECT_TRUE(plugin->check_remote_match(peer, question));
  question.remote_hides = true;
  const auto refused = plugin->check_remote_match(peer, question);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::match_not_permitted);
  EXPECT_NE(refused.error().details().note.find("without its endpoint_security_info"),
            std::string::npos);
  question.local.partitions = p;
  EXPECT_TRUE(plugin->check_remote_match(peer, question));
}

}  // namespace
}  // namespace ddssec::access_control
