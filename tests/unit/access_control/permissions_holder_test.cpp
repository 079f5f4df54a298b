// The end of permissions and of the CA that signed them, while participants use them.
#include "plugins/access_control/permissions_holder.hpp"

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

class PermissionsExpiry : public AccessControlTest {
 protected:
  std::string brief() const {
    auto ends = grant(kTalker, {rule(true)});
    ends.validity.not_after = kNow + 10s;
    return signed_permissions({ends});
  }

  // Two participants of the talker, and the listener as a peer of both.
  struct TwoLocals {
    TwoLocals(PermissionsExpiry& test, const std::string& own,
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

// T3 (docs/attacks.md): a peer stays matched after its permissions have expired.
TEST_F(PermissionsExpiry, EndedGrant_IsReportedOnceAndDeniesAlways) {
  const auto own = local(open_permissions(kTalker));
  auto brief = grant(kListener, {publish_rule(true, {"t"})});
  brief.validity.not_after = kNow + 10s;
  const auto peer = remote(signed_permissions({brief}));
  ASSERT_TRUE(own && peer);
  EXPECT_EQ(plugin->next_expiry(), kNow + 10s);
  EXPECT_TRUE(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "t"}));
  clock.advance(9s);
  EXPECT_TRUE(plugin->poll().empty());
  clock.advance(1s);
  EXPECT_REFUSED(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "t"}), grant_expired);
  EXPECT_REFUSED(plugin->check_remote_participant(*peer, 0), grant_expired);
  EXPECT_EQ(plugin->poll(), std::vector{*peer});
  ASSERT_EQ(log.all.size(), 1u);
  EXPECT_EQ(log.all[0].error.code(), Code::grant_expired);
  EXPECT_EQ(log.all[0].peer_subject, kListener);
  EXPECT_NE(log.all[0].error.to_sentence().find("2026-11-21T00:00:10Z"), std::string::npos);
  EXPECT_TRUE(plugin->poll().empty());
  EXPECT_EQ(plugin->next_expiry(), kNow + 24h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
}

TEST_F(PermissionsExpiry, OwnPermissions_AreWarnedOfBeforeTheirEnd) {
  auto of_100_days = grant(kTalker, {rule(true)});
  of_100_days.validity = {kNow, kNow + 100 * 24h};
  ASSERT_OK(local(signed_permissions({of_100_days})));
  std::vector<int> days;
  for (int day = 1; day < 100; ++day) {
    log.all.clear();
    clock.advance(24h);
    EXPECT_TRUE(plugin->poll().empty());
    EXPECT_TRUE(plugin->poll().empty());
    if (log.all.empty()) continue;
    EXPECT_EQ(log.only(), Code::permissions_end_soon);
    days.push_back(100 - day);
  }
  EXPECT_EQ(days, (std::vector{30, 7, 1}));
}

TEST_F(PermissionsExpiry, CaThatEndsBeforeThePermissions_IsWarnedOf) {
  const auto ca = pki::make_ca("CN=Short CA,O=Example", {}, {kNow - 24h, kNow + 100 * 24h - 1s});
  auto of_a_year = grant(kTalker, {rule(true)});
  of_a_year.validity = {kNow, kNow + 365 * 24h};
  auto all =
      properties(signed_document(governance::to_xml(governance_document)),
                 signed_by(ca, governance::to_xml(governance::Permissions{.grants = {of_a_year}})));
  for (auto& one : all)
    if (one.name == spi::property::kPermissionsCa)
      one.value =
          "data:," + authorities().permissions_ca.certificate().pem() + ca.certificate().pem();
  ASSERT_OK(plugin->validate_local_permissions(kLocalIdentity, 0, all));
  std::vector<int> days;
  for (int day = 1; day < 100; ++day) {
    log.all.clear();
    clock.advance(24h);
    EXPECT_TRUE(plugin->poll().empty());
    if (log.all.empty()) continue;
    EXPECT_EQ(log.only(), Code::permissions_end_soon);
    days.push_back(100 - day);
  }
  EXPECT_EQ(days, (std::vector{30, 7, 1}));
}

TEST_F(PermissionsExpiry, OwnPermissionsThatAnotherGrantFollows_AreNotWarnedOf) {
  auto first = grant(kTalker, {rule(true)}), second = first;
  first.validity = {kNow, kNow + 50 * 24h};
  second.validity = {kNow + 50 * 24h, kNow + 365 * 24h};
  ASSERT_OK(local(signed_permissions({first, second})));
  for (int day = 1; day < 100; ++day) {
    clock.advance(24h);
    plugin->poll();
  }
  EXPECT_TRUE(log.all.empty());
}

TEST_F(PermissionsExpiry, PeersPermissions_AreNotOurs) {
  ASSERT_OK(local(open_permissions(kTalker)));
  auto of_peer = grant(kListener, {rule(true)});
  of_peer.validity = {kNow - 24h * 20, kNow + 25h};
  ASSERT_OK(remote(signed_permissions({of_peer})));
  clock.advance(2h);
  plugin->poll();
  EXPECT_TRUE(log.all.empty());
}

// T4 (docs/attacks.md): the wall clock at the time of the check counts, even if it jumped.
// Permissions that were valid do not end when the clock is set back. Otherwise a clock that is
// wrong for a minute would part honest participants for good.
TEST_F(PermissionsExpiry, ClockThatJumps_IsFollowed) {
  const auto own = local(open_permissions(kTalker));
  ASSERT_TRUE(own);
  clock.set(kNow + 25h);
  EXPECT_REFUSED(plugin->check_create_participant(*own, 0), grant_expired);
  clock.set(kNow);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
  clock.set(kNow - 23h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
  clock.set(kNow - 48h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
  EXPECT_TRUE(plugin->poll().empty());
  EXPECT_REFUSED(local(open_permissions(kTalker)), certificate_not_yet_valid);
  clock.set(kNow + 25h);
  EXPECT_REFUSED(plugin->check_create_participant(*own, 0), grant_expired);
  EXPECT_EQ(plugin->poll().size(), 1u);
}

TEST_F(PermissionsExpiry, AnotherGrantOfTheDocument_TakesOver) {
  auto first = grant(kTalker, {rule(true)}), second = grant(kTalker, {rule(true)});
  first.validity.not_after = kNow + 10s;
  second.validity.not_before = kNow + 5s;
  const auto own = local(signed_permissions({first, second}));
  ASSERT_TRUE(own);
  EXPECT_EQ(plugin->next_expiry(), kNow + 10s);
  clock.advance(10s);
  EXPECT_TRUE(plugin->poll().empty());
  EXPECT_EQ(plugin->next_expiry(), kNow + 24h);
  EXPECT_TRUE(plugin->check_create_participant(*own, 0));
}

// Endpoints that were matched under the first grant are not judged again under the second one.
TEST_F(PermissionsExpiry, EndOfAPeersGrant_EndsThePeerUnlessTheNextGivesTheSame) {
  const auto own = local(open_permissions(kTalker));
  ASSERT_TRUE(own);
  const auto first_then = [&](governance::GrantRule rule, bool default_allow) {
    auto first = grant(kListener, {publish_rule(true, {"t", "u"})}), next = first;
    first.validity.not_after = clock.calendar_seconds() + 10s;
    next.validity.not_before = clock.calendar_seconds() + 5s;
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
  EXPECT_TRUE(plugin->poll().empty());
  clock.advance(10s);
  EXPECT_REFUSED(plugin->check_remote_datawriter(others[0], 0, {.topic_name = "t"}), grant_expired);
  log.all.clear();
  EXPECT_EQ(plugin->poll(), others);
  EXPECT_EQ(log.all.size(), others.size());
  for (const auto& event : log.all) EXPECT_EQ(event.error.code(), Code::grant_expired);
  EXPECT_TRUE(plugin->check_remote_datawriter(same, 0, {.topic_name = "u"}));
  EXPECT_TRUE(plugin->poll().empty());
}

// T2 (docs/attacks.md): an expired CA is accepted. Here the permissions CA ends.
TEST_F(PermissionsExpiry, EndOfThePermissionsCa_EndsWhatItSigned) {
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
  EXPECT_EQ(plugin->poll(), std::vector{*own});
}

// Cyclone DDS keeps the writers of a participant that it deleted, so their readers must go.
TEST_F(PermissionsExpiry, EndOfALocalParticipant_EndsItsPeersUnlessAnotherHasThem) {
  auto brief = grant(kTalker, {rule(true)});
  brief.validity.not_after = kNow + 10s;
  const auto own = local(signed_permissions({brief}));
  const auto peer = remote(open_permissions(kListener));
  ASSERT_TRUE(own && peer);
  clock.advance(10s);
  EXPECT_EQ(plugin->poll(), (std::vector{*own, *peer}));
  EXPECT_TRUE(plugin->poll().empty());
}

TEST_F(PermissionsExpiry, EndOfALocalParticipant_LeavesThePeersOfAnother) {
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
  EXPECT_EQ(plugin->poll(), std::vector{*own});
}

TEST_F(PermissionsExpiry, LocalParticipantsThatEndTogether_EndThePeersTheyShare) {
  TwoLocals two(*this, brief());
  clock.advance(10s);
  EXPECT_EQ(plugin->poll(), (std::vector{two.first, two.second, two.at_first, two.at_second}));
  EXPECT_TRUE(plugin->poll().empty());
}

// A host that has one participant must not get the events of another host's participant, nor take
// events away from it.
TEST_F(PermissionsExpiry, EndOfALocalParticipant_IsToldToItsOwnHostOnly) {
  TwoLocals two(*this, brief(), spi::IdentityHandle{9});
  clock.advance(10s);
  EXPECT_EQ(plugin->poll(two.second), (std::vector{two.second, two.at_second}));
  EXPECT_EQ(plugin->poll(two.first), (std::vector{two.first, two.at_first}));
  EXPECT_TRUE(plugin->poll().empty());
  EXPECT_TRUE(plugin->poll({99}).empty());
}

TEST_F(PermissionsExpiry, EndOfAPeer_IsToldToEachHostThatKnowsIt) {
  auto ends = grant(kListener, {rule(true)});
  ends.validity.not_after = kNow + 10s;
  TwoLocals two(*this, open_permissions(kTalker), kRemoteIdentity, signed_permissions({ends}));
  clock.advance(10s);
  EXPECT_EQ(plugin->poll(two.first), std::vector{two.at_first});
  EXPECT_EQ(plugin->poll(two.second), std::vector{two.at_second});
}

TEST_F(PermissionsExpiry, PluginWithoutParticipants_HasNoNextEnd) {
  EXPECT_EQ(plugin->next_expiry(), std::nullopt);
}

}  // namespace
}  // namespace ddssec::access_control
