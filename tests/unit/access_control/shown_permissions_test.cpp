// Renewed permissions that a peer shows within its session, and own permissions that it has seen.
#include <gmock/gmock.h>

#include "tests/unit/access_control/listener_peer.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class ShownPermissions : public ListenerPeerTest {
 protected:
  ShownPermissions() : ListenerPeerTest(12h) {
    EXPECT_TRUE(local(open_permissions(kTalker)));
    meet(document({"t"}));
    log.all.clear();
  }

  bool may_match(std::string_view topic) {
    return plugin
        ->check_remote_match(peer_,
                             {.remote_writes = true, .local = {.topic_name = topic}, .remote = {}})
        .has_value();
  }
};

TEST_F(ShownPermissions, Taken_CountFromThenOnUnderTheSameHandle) {
  EXPECT_TRUE(may_match("t"));
  EXPECT_FALSE(may_publish("u"));
  log.all.clear();
  ASSERT_TRUE(show(document({"u"}, 0s, 48h)));
  EXPECT_EQ(log.only(), Code::peer_permissions_renewed);
  EXPECT_FALSE(may_publish("t"));
  EXPECT_FALSE(may_match("t")) << "what was announced before is judged anew";
  EXPECT_TRUE(may_publish("u"));
  clock.advance(13h);
  EXPECT_THAT(plugin->poll(), IsEmpty()) << "the former end does not count";
  clock.advance(12h);
  plugin->poll();
  clock.advance(24h);
  EXPECT_FALSE(may_publish("u"));
}

TEST_F(ShownPermissions, SameDocumentAgain_IsNoEvent) {
  const auto text = document({"t"}, 0s, 48h);
  ASSERT_TRUE(show(text));
  log.all.clear();
  ASSERT_TRUE(show(text));
  EXPECT_THAT(log.all, IsEmpty());
}

TEST_F(ShownPermissions, FewerRights_AreReported) {
  const auto more = document({"t", "u"}, 0s, 48h);
  EXPECT_FALSE(show(more).value_or(true));
  EXPECT_FALSE(show(more).value_or(true)) << "the same document";
  EXPECT_TRUE(show(document({"u"}, 0s, 48h)).value_or(false));
}

TEST_F(ShownPermissions, EarlierBegin_IsRefusedAsARollBack) {
  EXPECT_REFUSED(show(document({"t", "u"}, -25h, 48h)), permissions_renewal_refused);
  EXPECT_FALSE(may_publish("u"));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ShownPermissions, EarlierSignature_IsRefusedAsARollBack) {
  const auto wide = document({"t", "u"});
  signing_time += 10s;
  ASSERT_TRUE(show(document({"t"})));
  EXPECT_REFUSED(show(wide), permissions_renewal_refused);
  EXPECT_FALSE(may_publish("u"));
  signing_time += 10s;
  EXPECT_TRUE(show(document({"t", "u"})));
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ShownPermissions, AnotherSubject_IsRefused) {
  EXPECT_REFUSED(show(document({"u"}, 0s, 48h, kTalker)), no_grant_for_subject);
  // They are refused also together with the other identity's certificate: the session is the
  // listener's.
  EXPECT_REFUSED(plugin->renew_remote_permissions(
                     peer_, permissions_token(),
                     credential(authorities().talker, document({"u"}, 0s, 48h, kTalker))),
                 no_grant_for_subject);
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ShownPermissions, AnotherCa_IsRefused) {
  const auto xml = governance::to_xml(
      governance::Permissions{.grants = {grant(kListener, {publish_rule(true, {"u"})})}});
  log.all.clear();
  EXPECT_REFUSED(show(signed_by(authorities().other_ca, xml)), smime_signer_not_permissions_ca);
  EXPECT_FALSE(may_publish("u"));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ShownPermissions, InvalidNow_AreRefused) {
  log.all.clear();
  EXPECT_REFUSED(show(document({"u"}, 1h, 48h)), grant_not_yet_valid);
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ShownPermissions, PeerThatHasEnded_IsRefused) {
  clock.advance(13h);
  EXPECT_THAT(plugin->poll(), ElementsAre(peer_));
  EXPECT_REFUSED(show(document({"t"}, 12h, 48h)), permissions_renewal_refused);
}

TEST_F(ShownPermissions, UnderAnUnknownHandle_AreRefused) {
  EXPECT_TRUE(plugin->return_permissions_handle(peer_));
  EXPECT_REFUSED(show(document({"t"}, 0s, 48h)), unknown_permissions_handle);
  EXPECT_REFUSED(plugin->note_presented(peer_, {}), unknown_permissions_handle);
}

}  // namespace
}  // namespace ddssec::access_control
