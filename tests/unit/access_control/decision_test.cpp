#include "tests/unit/access_control/fixture.hpp"

namespace ddssec::access_control {
namespace {

using spi::EndpointRequest;
using Partitions = std::vector<std::string_view>;

class Decisions : public AccessControlTest {
 protected:
  /// "open" has no access control, "written" only write control, the rest both.
  void SetUp() override {
    auto& rules = governance_document.domain_rules[0].topic_rules;
    rules = {{.topic_expression = "open",
              .enable_read_access_control = false,
              .enable_write_access_control = false},
             {.topic_expression = "written", .enable_read_access_control = false},
             {.topic_expression = "closed*"}};
  }
  spi::PermissionsHandle with(std::vector<governance::Rule> rules, bool default_allow = false) {
    auto content = grant(kTalker, std::move(rules));
    content.default_allow = default_allow;
    const auto handle = local(signed_permissions({content}));
    EXPECT_TRUE(handle) << handle.error().to_sentence();
    return *handle;
  }
  spi::PermissionsHandle peer_with(std::vector<governance::Rule> rules,
                                   bool default_allow = false) {
    if (!local_) local_ = with({rule(true)});
    auto content = grant(kListener, std::move(rules));
    content.default_allow = default_allow;
    const auto handle = remote(signed_permissions({content}));
    EXPECT_TRUE(handle) << handle.error().to_sentence();
    return *handle;
  }
  spi::PermissionsHandle local_;
};

TEST_F(Decisions, JoiningNeedsAnAllowRuleOfTheDomain) {
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

TEST_F(Decisions, PeersJoinByTheirOwnPermissions) {
  EXPECT_TRUE(plugin->check_remote_participant(peer_with({rule(true)}), 0));
  EXPECT_REFUSED(plugin->check_remote_participant(peer_with({}), 0), participant_not_allowed);
}

TEST_F(Decisions, WritersAndReadersAreJudgedApart) {
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

TEST_F(Decisions, WithoutAccessControlEverybodyMay) {
  const auto handle = with({rule(true)});
  EXPECT_TRUE(plugin->check_create_datawriter(handle, 0, {.topic_name = "open"}));
  EXPECT_TRUE(plugin->check_create_datareader(handle, 0, {.topic_name = "open"}));
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "open"));
  EXPECT_REFUSED(plugin->check_create_datawriter(handle, 0, {.topic_name = "written"}),
                 publish_not_allowed);
  EXPECT_TRUE(plugin->check_create_datareader(handle, 0, {.topic_name = "written"}));
  EXPECT_TRUE(plugin->check_create_topic(handle, 0, "written"));
}

TEST_F(Decisions, TopicWithoutRuleIsRefusedEverywhere) {
  const auto handle = with({rule(true)}, true);
  const EndpointRequest request{.topic_name = "unheard"};
  EXPECT_REFUSED(plugin->check_create_datawriter(handle, 0, request), topic_not_covered);
  EXPECT_REFUSED(plugin->check_create_datareader(handle, 0, request), topic_not_covered);
  EXPECT_REFUSED(plugin->check_create_topic(handle, 0, "unheard"), topic_not_covered);
  EXPECT_REFUSED(plugin->datawriter_sec_attributes(handle, request), topic_not_covered);
  EXPECT_REFUSED(plugin->datareader_sec_attributes(handle, request), topic_not_covered);
  EXPECT_REFUSED(plugin->topic_sec_attributes(handle, "unheard"), topic_not_covered);
}

TEST_F(Decisions, PeersAreJudgedByLocalGovernanceAndTheirPermissions) {
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  EXPECT_TRUE(plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed_out"}));
  EXPECT_TRUE(plugin->check_remote_topic(peer, 0, "closed_out"));
  EXPECT_TRUE(plugin->check_remote_datareader(peer, 0, {.topic_name = "open"}));
  EXPECT_REFUSED(plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed_in"}),
                 publish_not_allowed);
  EXPECT_REFUSED(plugin->check_remote_datareader(peer, 0, {.topic_name = "closed_out"}),
                 subscribe_not_allowed);
  EXPECT_REFUSED(plugin->check_remote_datawriter(peer, 0, {.topic_name = "unheard"}),
                 topic_not_covered);
}

TEST_F(Decisions, ARefusalSaysThatOnlyThePartitionIsNotAllowed) {
  auto allowed = publish_rule(true, {"closed"});
  allowed.publish[0].partitions = {{{"p", 0}}};
  const Partitions wrong = {"q"};
  const EndpointRequest request{.topic_name = "closed", .partitions = wrong};
  const auto peer = peer_with({allowed});
  for (const auto& refused : {plugin->check_create_datawriter(with({allowed}), 0, request),
                              plugin->check_remote_datawriter(peer, 0, request)}) {
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().hint().find("the topic is allowed, but not in partition \"q\""),
              std::string::npos)
        << refused.error().hint();
  }
}

TEST_F(Decisions, ANameThatIsCloseIsProposedToTheLocalParticipantOnly) {
  const auto allowed = publish_rule(true, {"closed_chatter"});
  const EndpointRequest request{.topic_name = "closed_chater"};
  const auto own = plugin->check_create_datawriter(with({allowed}), 0, request);
  const auto peers = plugin->check_remote_datawriter(peer_with({allowed}), 0, request);
  ASSERT_FALSE(own);
  ASSERT_FALSE(peers);
  EXPECT_NE(own.error().hint().find("is \"closed_chatter\" meant?"), std::string::npos);
  EXPECT_EQ(peers.error().hint(), info(Code::publish_not_allowed).hint);
}

// RVD#447: partitions count for peers too.
TEST_F(Decisions, PartitionsAndTagsOfPeersCount) {
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
  EXPECT_REFUSED(check(wrong, {}), publish_not_allowed);
  EXPECT_REFUSED(check(both, {}), publish_not_allowed);
  EXPECT_REFUSED(check({}, {}), publish_not_allowed);
  EXPECT_REFUSED(check(right, blue), publish_not_allowed);
  make({.partition_match = governance::PartitionMatch::one});
  local_ = {};
  const auto legacy = peer_with({allowed});
  EXPECT_TRUE(
      plugin->check_remote_datawriter(legacy, 0, {.topic_name = "closed", .partitions = both}));
}

spi::AccessControl::Match match(const EndpointRequest& local, bool remote_writes = true) {
  return {.remote_writes = remote_writes,
          .local = local,
          .remote = GuidPrefix{{0x81, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}};
}

// A program that prints its errors and its events prints each refusal once.
TEST_F(Decisions, AnEventSaysWhetherTheApplicationGetsTheErrorToo) {
  const auto expect_returned = [&](bool is_returned, const auto& refused) {
    EXPECT_FALSE(refused);
    ASSERT_EQ(log.events.size(), 1u);
    EXPECT_EQ(log.events[0].is_returned, is_returned);
    log.events.clear();
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

TEST_F(Decisions, AMatchIsJudgedWhetherOrNotTheHostAskedBefore) {
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "closed_out"})));
  log.events.clear();
  const auto refused = plugin->check_remote_match(peer, match({.topic_name = "closed_in"}));
  EXPECT_CODE(refused, match_not_permitted);
  ASSERT_EQ(log.events.size(), 1u);
  const auto& event = log.events[0];
  EXPECT_EQ(event.peer_subject, kListener);
  EXPECT_EQ(event.guid, "810102030405060708090a0b.000001c1");
  const auto& details = event.error.details();
  EXPECT_EQ(details.expected, "an allow_rule to publish topic \"closed_in\"");
  EXPECT_EQ(details.document, refused.error().details().document);
  EXPECT_GT(details.line, 0);
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "closed_out"}, false)),
                 match_not_permitted);
  // What governance leaves open is open; "written" may be read by all.
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "open"})));
  EXPECT_TRUE(plugin->check_remote_match(peer, match({.topic_name = "written"}, false)));
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "written"})),
                 match_not_permitted);
  EXPECT_TRUE(plugin->return_permissions_handle(peer));
  EXPECT_REFUSED(plugin->check_remote_match(peer, match({.topic_name = "closed_out"})),
                 unknown_permissions_handle);
}

TEST_F(Decisions, AMatchIsJudgedByOurPartitionsUnlessThePeerAnnouncedOthersThatMeetThem) {
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
  EXPECT_REFUSED(announce(both), publish_not_allowed);  // is not remembered
  EXPECT_REFUSED(may(both), match_not_permitted);
  EXPECT_TRUE(announce(p));
  EXPECT_TRUE(may(both));
  EXPECT_TRUE(may(all));
  EXPECT_REFUSED(may(q), match_not_permitted);
  EXPECT_REFUSED(may({}), match_not_permitted);
  clock.set(kNow + 25h);  // and not longer than the grant
  EXPECT_REFUSED(may(both), match_not_permitted);
}

TEST_F(Decisions, RelaysAreLetInOnlyIfAsked) {
  auto relay = rule(true);
  relay.relay = {topics({"closed_relay"})};
  const EndpointRequest request{.topic_name = "closed_relay"};
  EXPECT_REFUSED(plugin->check_remote_datareader(peer_with({relay}), 0, request),
                 subscribe_not_allowed);
  make({.accept_relays = true});
  local_ = {};
  const auto relayed = plugin->check_remote_datareader(peer_with({relay}), 0, request);
  ASSERT_TRUE(relayed);
  EXPECT_TRUE(relayed->relay_only);
  relay.subscribe = {topics({"closed_relay"})};
  const auto reader = plugin->check_remote_datareader(peer_with({relay}), 0, request);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->relay_only);
  // The default does not make a relay.
  const auto denied = peer_with({subscribe_rule(false, {"closed_relay"})}, true);
  EXPECT_REFUSED(plugin->check_remote_datareader(denied, 0, request), subscribe_not_allowed);
}

TEST_F(Decisions, RefusalNamesDocumentLineRuleAndValues) {
  const auto handle = with({publish_rule(false, {"closed_b"}), publish_rule(true, {"closed_*"})});
  const Partitions partitions = {""};
  const auto status = plugin->check_create_datawriter(
      handle, 0, {.topic_name = "closed_b", .partitions = partitions});
  ASSERT_FALSE(status);
  const auto& details = status.error().details();
  EXPECT_EQ(details.document, "dds.sec.access.permissions");
  EXPECT_EQ(details.line, 17);
  EXPECT_EQ(details.field, "<deny_rule>");
  EXPECT_EQ(details.expected, "an allow_rule to publish topic \"closed_b\" in partition \"\"");
  EXPECT_NE(details.note.find(kTalker), std::string::npos);
}

TEST_F(Decisions, AttributesAreAsTheDocumentSays) {
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

TEST_F(Decisions, BuiltinSecureTopicsHaveAttributes) {
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

class Expiry : public AccessControlTest {
 protected:
  std::string brief() const {
    auto ends = grant(kTalker, {rule(true)});
    ends.validity.not_after = kNow + 10s;
    return signed_permissions({ends});
  }

  /// Two participants of the talker, and the listener as a peer of both.
  struct TwoLocals {
    TwoLocals(Expiry& test, const std::string& own,
              spi::IdentityHandle remote_of_second = kRemoteIdentity,
              const std::string& of_peer = {}) {
      const auto document = of_peer.empty() ? test.open_permissions(kListener) : of_peer;
      constexpr spi::IdentityHandle kSecond{3};
      first = test.local(own).value();
      at_first = test.remote(document).value();
      second = test.plugin
                   ->validate_local_permissions(
                       kSecond, 0,
                       test.properties(
                           test.signed_document(governance::to_xml(test.governance_document)), own))
                   .value();
      at_second =
          test.plugin
              ->validate_remote_permissions(kSecond, remote_of_second, test.permissions_token(),
                                            test.credential(test.authorities().listener, document))
              .value();
    }
    spi::PermissionsHandle first, second, at_first, at_second;
  };
};

// T3
TEST_F(Expiry, IsToldReportedOnceAndDeniesEvenIfTheHostForgets) {
  const auto own = local(open_permissions(kTalker));
  auto brief = grant(kListener, {publish_rule(true, {"t"})});
  brief.validity.not_after = kNow + 10s;
  const auto peer = remote(signed_permissions({brief}));
  ASSERT_TRUE(own && peer);
  EXPECT_EQ(plugin->next_expiry(), kNow + 10s);
  EXPECT_TRUE(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "t"}));
  clock.advance(9s);
  EXPECT_TRUE(plugin->expire().empty());
  clock.advance(1s);
  EXPECT_REFUSED(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "t"}), grant_expired);
  EXPECT_REFUSED(plugin->check_remote_participant(*peer, 0), grant_expired);
  EXPECT_EQ(plugin->expire(), std::vector{*peer});
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_EQ(log.events[0].error.code(), Code::grant_expired);
  EXPECT_EQ(log.events[0].peer_subject, kListener);
  EXPECT_NE(log.events[0].error.to_sentence().find("2026-11-21T00:00:10Z"), std::string::npos);
  EXPECT_TRUE(plugin->expire().empty());
  EXPECT_EQ(plugin->next_expiry(), kNow + 24h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
}

// T4: the wall clock at the check counts, wherever it jumped.
TEST_F(Expiry, FollowsAClockThatJumps) {
  const auto own = local(open_permissions(kTalker));
  ASSERT_TRUE(own);
  clock.set(kNow + 25h);
  EXPECT_REFUSED(plugin->check_create_participant(*own, 0), grant_expired);
  clock.set(kNow);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
  clock.set(kNow - 23h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
  clock.set(kNow - 48h);
  EXPECT_REFUSED(plugin->check_create_participant(*own, 0), certificate_not_yet_valid);
  EXPECT_EQ(plugin->expire().size(), 1u);
}

TEST_F(Expiry, AnotherGrantOfTheDocumentTakesOver) {
  auto first = grant(kTalker, {rule(true)}), second = grant(kTalker, {rule(true)});
  first.validity.not_after = kNow + 10s;
  second.validity.not_before = kNow + 5s;
  const auto own = local(signed_permissions({first, second}));
  ASSERT_TRUE(own);
  EXPECT_EQ(plugin->next_expiry(), kNow + 10s);
  clock.advance(10s);
  EXPECT_TRUE(plugin->expire().empty());
  EXPECT_EQ(plugin->next_expiry(), kNow + 24h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
}

// What was matched under the first grant is not judged again under the second.
TEST_F(Expiry, OfAPeersGrantEndsThePeerUnlessTheNextOneGivesTheSame) {
  const auto own = local(open_permissions(kTalker));
  ASSERT_TRUE(own);
  const auto first_then = [&](governance::Rule rule, bool default_allow) {
    auto first = grant(kListener, {publish_rule(true, {"t", "u"})}), next = first;
    first.validity.not_after = clock.now() + 10s;
    next.validity.not_before = clock.now() + 5s;
    next.rules = {std::move(rule)};
    next.default_allow = default_allow;
    next.line = 99;
    return remote(signed_permissions({first, next})).value();
  };
  auto elsewhere = publish_rule(true, {"t", "u"});
  elsewhere.publish[0].partitions = {{"p", 0}};
  const auto same = first_then(publish_rule(true, {"t", "u"}), false);
  const std::vector others = {first_then(publish_rule(true, {"t"}), false),
                              first_then(elsewhere, false),
                              first_then(subscribe_rule(true, {"t", "u"}), false),
                              first_then(publish_rule(false, {"t", "u"}), false),
                              first_then(publish_rule(true, {"t", "u"}), true)};
  EXPECT_TRUE(plugin->expire().empty());
  clock.advance(10s);
  EXPECT_REFUSED(plugin->check_remote_datawriter(others[0], 0, {.topic_name = "t"}), grant_expired);
  log.events.clear();
  EXPECT_EQ(plugin->expire(), others);
  EXPECT_EQ(log.events.size(), others.size());
  for (const auto& event : log.events) EXPECT_EQ(event.error.code(), Code::grant_expired);
  EXPECT_TRUE(plugin->check_remote_datawriter(same, 0, {.topic_name = "u"}));
  EXPECT_TRUE(plugin->expire().empty());
}

// T2: the permissions CA ends.
TEST_F(Expiry, OfThePermissionsCaEndsWhatItSigned) {
  auto ca = pki::make_ca("CN=Brief CA", {}, {kNow - 24h, kNow + 10s});
  auto list = properties(signed_by(ca, governance::to_xml(governance_document)),
                         signed_by(ca, governance::to_xml(governance::Permissions{
                                           .grants = {grant(kTalker, {rule(true)})}})));
  list[1].value = "data:," + ca.certificate().pem();
  const auto own = plugin->validate_local_permissions(kLocalIdentity, 0, list);
  ASSERT_TRUE(own) << own.error().to_sentence();
  EXPECT_EQ(plugin->next_expiry(), kNow + 11s);
  clock.advance(11s);
  EXPECT_REFUSED(plugin->check_create_participant(*own, 0), certificate_expired);
  EXPECT_EQ(plugin->expire(), std::vector{*own});
}

// Cyclone DDS keeps the writers of a participant that it deleted: their readers must go.
TEST_F(Expiry, OfALocalParticipantEndsItsPeersUnlessAnotherOneHasThem) {
  auto brief = grant(kTalker, {rule(true)});
  brief.validity.not_after = kNow + 10s;
  const auto own = local(signed_permissions({brief}));
  const auto peer = remote(open_permissions(kListener));
  ASSERT_TRUE(own && peer);
  clock.advance(10s);
  EXPECT_EQ(plugin->expire(), (std::vector{*own, *peer}));
  EXPECT_TRUE(plugin->expire().empty());
}

TEST_F(Expiry, OfALocalParticipantLeavesThePeersOfAnotherOne) {
  auto brief = grant(kTalker, {rule(true)});
  brief.validity.not_after = kNow + 10s;
  const auto own = local(signed_permissions({brief}));
  const auto peer = remote(open_permissions(kListener));
  const spi::IdentityHandle steady{3};
  ASSERT_TRUE(plugin->validate_local_permissions(
      steady, 0,
      properties(signed_document(governance::to_xml(governance_document)),
                 open_permissions(kTalker))));
  ASSERT_TRUE(own && peer);
  ASSERT_TRUE(plugin->validate_remote_permissions(
      steady, kRemoteIdentity, permissions_token(),
      credential(authorities().listener, open_permissions(kListener))));
  clock.advance(10s);
  EXPECT_EQ(plugin->expire(), std::vector{*own});
}

TEST_F(Expiry, OfLocalParticipantsThatEndTogetherEndsThePeersThatTheyShare) {
  TwoLocals two(*this, brief());
  clock.advance(10s);
  EXPECT_EQ(plugin->expire(), (std::vector{two.first, two.second, two.at_first, two.at_second}));
  EXPECT_TRUE(plugin->expire().empty());
}

// Hosts of one participant each must not be told of others', nor take what others have to hear.
TEST_F(Expiry, IsToldToWhomItConcerns) {
  TwoLocals two(*this, brief(), spi::IdentityHandle{9});
  clock.advance(10s);
  EXPECT_EQ(plugin->expire(two.second), (std::vector{two.second, two.at_second}));
  EXPECT_EQ(plugin->expire(two.first), (std::vector{two.first, two.at_first}));
  EXPECT_TRUE(plugin->expire().empty());
  EXPECT_TRUE(plugin->expire({99}).empty());
}

TEST_F(Expiry, OfThePeerIsToldToEachThatKnowsIt) {
  auto ends = grant(kListener, {rule(true)});
  ends.validity.not_after = kNow + 10s;
  TwoLocals two(*this, open_permissions(kTalker), kRemoteIdentity, signed_permissions({ends}));
  clock.advance(10s);
  EXPECT_EQ(plugin->expire(two.first), std::vector{two.at_first});
  EXPECT_EQ(plugin->expire(two.second), std::vector{two.at_second});
}

TEST_F(Expiry, NobodyNoEnd) { EXPECT_EQ(plugin->next_expiry(), std::nullopt); }

class Cache : public AccessControlTest {
 protected:
  std::shared_ptr<const PermissionsCa> ca() const {
    auto loaded = PermissionsCa::load("data:," + authorities().permissions_ca.certificate().pem());
    EXPECT_TRUE(loaded);
    return *loaded;
  }
};

TEST_F(Cache, ADocumentIsReadOnce) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  const auto first = cache.permissions(*ca(), as_bytes(document), kNow);
  const auto second = cache.permissions(*ca(), as_bytes(document), kNow);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  EXPECT_EQ(cache.times_read(), 1u);
}

TEST_F(Cache, OnlyVerifiedDocumentsGetIn) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto forged = signed_by(authorities().other_ca, "<dds/>");
  EXPECT_CODE(cache.permissions(*ca(), as_bytes(forged), kNow), smime_signer_not_permissions_ca);
  EXPECT_EQ(cache.size(), 0u);
}

TEST_F(Cache, AnotherCaJudgesAnew) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  ASSERT_TRUE(cache.permissions(*ca(), as_bytes(document), kNow));
  const auto other = PermissionsCa::load("data:," + authorities().other_ca.certificate().pem());
  ASSERT_TRUE(other);
  EXPECT_CODE(cache.permissions(**other, as_bytes(document), kNow),
              smime_signer_not_permissions_ca);
}

TEST_F(Cache, IsBoundedInNumberAndOctets) {
  DocumentCache few(governance::PartitionMatch::all, 2, 1 << 20);
  const std::vector<std::string> documents = {open_permissions("CN=a"), open_permissions("CN=b"),
                                              open_permissions("CN=c")};
  for (const auto& document : documents) {
    ASSERT_TRUE(few.permissions(*ca(), as_bytes(document), kNow));
    ASSERT_TRUE(few.permissions(*ca(), as_bytes(documents[0]), kNow));
  }
  EXPECT_EQ(few.size(), 2u);
  EXPECT_EQ(few.times_read(), 3u);  // the first was used in between and stayed
  DocumentCache small(governance::PartitionMatch::all, 100, documents[0].size() + 10);
  for (const auto& document : documents) {
    ASSERT_TRUE(small.permissions(*ca(), as_bytes(document), kNow));
  }
  EXPECT_EQ(small.size(), 1u);
}

// A peer can send its document with other blank lines each time.
TEST_F(Cache, FormsOfOneTextShareAPlace) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  const auto first = cache.permissions(*ca(), as_bytes(document), kNow);
  ASSERT_TRUE(first);
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 1; i < 20; ++i) {
      const auto again = cache.permissions(*ca(), as_bytes(document + std::string(i, '\n')), kNow);
      ASSERT_TRUE(again);
      EXPECT_EQ(*again, *first);
    }
  }
  EXPECT_EQ(cache.size(), 1u);
  EXPECT_EQ(cache.times_read(), 1u);
  // Those forms go with it.
  DocumentCache one(governance::PartitionMatch::all, 1, 1 << 20);
  for (int round = 0; round < 2; ++round)
    for (const auto& text : {document, document + "\n", open_permissions("CN=a")})
      EXPECT_TRUE(one.permissions(*ca(), as_bytes(text), kNow));
  EXPECT_EQ(one.size(), 1u);
  EXPECT_EQ(one.times_read(), 4u);
}

TEST_F(Cache, AnExpiredCaIsSeenInTheCacheToo) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  ASSERT_TRUE(cache.permissions(*ca(), as_bytes(document), kNow));
  EXPECT_CODE(cache.permissions(*ca(), as_bytes(document), kNow + 400 * 24h), certificate_expired);
}

TEST_F(Cache, ManySubjectsOfOneDocumentAreCompiledWithinBounds) {
  std::vector<governance::Grant> grants;
  for (int i = 0; i < 200; ++i) {
    grants.push_back(grant("CN=p" + std::to_string(i), {publish_rule(true, {"t"})}));
  }
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document =
      cache.permissions(*ca(), as_bytes(signed_permissions(std::move(grants))), kNow);
  ASSERT_TRUE(document) << document.error().to_sentence();
  for (int i = 0; i < 200; ++i) {
    const auto text = "CN=p" + std::to_string(i);
    EXPECT_TRUE((*document)->grant_for(*pki::SubjectName::parse(text), text, 0, "", kNow));
  }
}

}  // namespace
}  // namespace ddssec::access_control
