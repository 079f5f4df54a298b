// Permissions of peers that a renewal list extends.
#include "plugins/access_control/listed_permission_peers.hpp"

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"
#include "tests/unit/access_control/listed_peers.hpp"

namespace ddssec::access_control {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

TEST_F(ListedPeers, TheSameRights_KeepThePeer) {
  put({document({"t"}, 0s, 12h)});
  EXPECT_THAT(poll(), IsEmpty());
  ASSERT_EQ(log.all.size(), 1u);
  const auto& event = log.all.front();
  EXPECT_EQ(event.error.code(), Code::peer_permissions_listed);
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.peer_subject, kListener);
  EXPECT_EQ(event.error.details().found, to_string(kNow + 12h));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(log.all.size(), 1u);
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_EQ(plugin->next_expiry(), kNow + 12h);
}

TEST_F(ListedPeers, PeerWithoutAList_EndsInTime) {
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
}

TEST_F(ListedPeers, AListOfTheLastSecond_Counts) {
  poll(19s);
  put({document({"t"}, 0s, 24h)});
  EXPECT_THAT(poll(1s), IsEmpty());
}

TEST_F(ListedPeers, AListThatIsThereAtTheStart_KeepsThePeer) {
  (void)plugin->return_permissions_handle(peer_);
  (void)plugin->return_permissions_handle(own_);
  put({document({"t"}, 0s, 24h)});
  own_ = ours({}, "").value();
  meet(document({"t"}));
  EXPECT_THAT(poll(20s), IsEmpty());
}

TEST_F(ListedPeers, TheBeginOfTheSameRights_SaysNothing) {
  put({document({"t"}, -25h, 40s)});
  EXPECT_THAT(poll(20s), IsEmpty());
  put({document({"t"}, -24h, 60s)});
  EXPECT_THAT(poll(20s), IsEmpty());
  EXPECT_THAT(poll(20s), ElementsAre(peer_));
}

TEST_F(ListedPeers, TheSameRightsAfterTheEnd_AreTooLate) {
  put({document({"t"}, 21s, 24h)});
  EXPECT_THAT(poll(20s), ElementsAre(peer_));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_FALSE(may_publish("t"));
}

TEST_F(ListedPeers, AnExtension_EndsWithItsOwnTimeInTheEvent) {
  put({document({"t"}, 0s, 40s)});
  EXPECT_THAT(poll(39s), IsEmpty());
  log.all.clear();
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
  ASSERT_EQ(log.all.size(), 1u);
  EXPECT_EQ(log.all.front().error.code(), Code::grant_expired);
  EXPECT_THAT(log.all.front().error.to_sentence(), testing::HasSubstr(to_string(kNow + 40s)));
}

TEST_F(ListedPeers, AClockThatGoesBack_EndsNoExtension) {
  put({document({"t"}, 0s, 24h)});
  poll(30s);
  clock.set(kNow + 1s);
  EXPECT_THAT(plugin->poll(), IsEmpty());
  clock.set(kNow - 1s);
  EXPECT_THAT(plugin->poll(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, AListThatNoLongerHasIt_LeavesAnExtensionUntilItsEnd) {
  put({document({"t"}, 0s, 60s)});
  poll();
  put({document({"t"}, 0s, 24h, kTalker)});
  EXPECT_THAT(poll(54s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
}

// The wide document is signed, and is valid until its end. Only a revocation of the certificate can
// take these rights away earlier.
TEST_F(ListedPeers, ALaterEntryWithLessRights_LeavesThePeerUntilTheWideOneEnds) {
  meet(document({"t", "u"}));
  const auto wide = document({"t", "u"}, 0s, 60s);
  put({wide});
  poll();
  put({wide, document({"t"}, 5s, 24h)});
  EXPECT_THAT(poll(50s), Not(Contains(peer_)));
  EXPECT_TRUE(may_publish("u"));
  EXPECT_THAT(poll(5s), Contains(peer_));
}

TEST_F(ListedPeers, AFormerListWithTheSameRights_GivesNoTimeBack) {
  const auto former = document({"t"}, 0s, 40s);
  put({former});
  poll();
  put({document({"t"}, 0s, 60s)});
  poll();
  put({former});
  EXPECT_THAT(poll(49s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
}

// ---- what a peer shows within its session

TEST_F(ListedPeers, ShownPermissionsThatBeginBeforeTheExtension_AreTaken) {
  put({document({"t"}, 0s, 24h)});
  poll();
  EXPECT_TRUE(show(document({"t"}, -23h, 60s)));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(ListedPeers, ShownPermissionsWithOtherRights_AreNotExtendedByTheFormer) {
  put({document({"t"}, 0s, 24h)});
  poll();
  EXPECT_TRUE(show(document({"u"}, -23h, 60s)));
  EXPECT_TRUE(may_publish("u"));
  EXPECT_FALSE(may_publish("t"));
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

// ---- lists that cannot be used

TEST_F(ListedPeers, SignedByAnotherCa_IsOneEventAndChangesNothing) {
  put({document({"t"}, 0s, 12h)});
  poll();
  log.all.clear();
  auto out = grant(kListener, {publish_rule(true, {"t"})});
  out.validity = {kNow + 1s, kNow + 48h};
  const auto forged = signed_by(authorities().other_ca,
                                governance::to_xml(governance::Permissions{.grants = {out}}));
  put({forged});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_permissions_refused));
  EXPECT_EQ(plugin->next_expiry(), kNow + 12h);
  put({forged, document({"t"}, 0s, 18h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(plugin->next_expiry(), kNow + 18h);
}

// Authentication reports such a list, so access control raises no event.
TEST_F(ListedPeers, AListThatCannotBeRead_ChangesNothing) {
  put({document({"t"}, 0s, 24h)});
  poll();
  log.all.clear();
  folder_.replace("renewed.pem", "garbage");
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(log.all, IsEmpty());
}

// ---- the record of documents in use

TEST_F(ListedPeers, Record_HasTheListedPermissionsWithTheirEnd) {
  const auto recorded = [&] { return test::recorded_document(documents, "listed permissions"); };
  EXPECT_TRUE(recorded().is_null());
  const auto good = document({"t"}, 0s, 12h);
  put({good});
  poll();
  EXPECT_EQ(recorded()["file"], path_);
  ASSERT_EQ(recorded()["in_force"].size(), 1u);
  EXPECT_EQ(recorded()["in_force"][0]["subject"], kListener);
  EXPECT_EQ(recorded()["in_force"][0]["until"], to_string(kNow + 12h));
  EXPECT_EQ(recorded()["in_force"][0]["sha256"], to_hex(sha256(as_bytes(good))));
  EXPECT_TRUE(recorded()["refused"].is_null());

  auto two = grant(kTalker, {publish_rule(true, {"t"})}), later = two;
  later.subject_name = kListener;
  later.validity.not_after = kNow + 48h;
  put({signed_by(authorities().other_ca,
                 governance::to_xml(governance::Permissions{.grants = {two}}))});
  codes_after_looking();
  EXPECT_EQ(recorded()["refused"]["name"], "renewal_list_permissions_refused");
  EXPECT_EQ(recorded()["refused"]["stands"], true);
  EXPECT_EQ(recorded()["in_force"].size(), 1u);

  put({good, signed_permissions({two, later})});
  codes_after_looking();
  EXPECT_EQ(recorded()["refused"]["stands"], false);
  ASSERT_EQ(recorded()["in_force"].size(), 2u);
  EXPECT_EQ(recorded()["in_force"][1]["subject"], std::string(kTalker) + " and 1 more");
  EXPECT_EQ(recorded()["in_force"][1]["until"], to_string(kNow + 48h));

  put({});
  codes_after_looking();
  EXPECT_EQ(recorded()["in_force"].size(), 0u);
  (void)plugin->return_permissions_handle(own_);
  EXPECT_TRUE(recorded().is_null());
}

// ---- our own permissions, which the peer has seen

class OwnListedPermissions : public ListedPeers {
 protected:
  // The local permissions end first, and are renewed. The peer has seen the former ones.
  void begin(bool peer_reads_lists, const std::vector<std::string>& next_topics = {"*"},
             const std::vector<std::string>& first_topics = {"*"}) {
    (void)plugin->return_permissions_handle(peer_);
    (void)plugin->return_permissions_handle(own_);
    const auto first = open(-24h, 20s, first_topics);
    own_ = ours("file:" + folder_.write("permissions.p7s", first), "-").value();
    meet(open_permissions(kListener), {.presented_permissions = sha256(as_bytes(first)),
                                       .peer_keeps_session = false,
                                       .peer_reads_lists = peer_reads_lists});
    next_ = open(0s, 24h, next_topics);
    folder_.replace("permissions.p7s", next_);
    poll();
    log.all.clear();
  }
  std::string open(std::chrono::seconds from, std::chrono::seconds until,
                   const std::vector<std::string>& topics = {"*"}) const {
    auto out = grant(kTalker, {publish_rule(true, topics)});
    out.validity = {kNow + from, kNow + until};
    return signed_permissions({out});
  }
  std::string next_;
};

TEST_F(OwnListedPermissions, RenewedPermissionsOnTheList_KeepTheSession) {
  begin(true);
  put({next_});
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(OwnListedPermissions, AnExtensionOfWhatThePeerHasSeen_KeepsTheSession) {
  begin(true);
  put({open(1s, 12h)});
  EXPECT_THAT(pass_the_end(), IsEmpty()) << "the peer goes by it, too";
}

// The peer does not judge us by permissions with other rights, so its session ends.
TEST_F(OwnListedPermissions, RenewedPermissionsWithOtherRights_EndTheSession) {
  begin(true, {"t"});
  put({next_});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::session_outlived_documents));
}

// The peer judges us by the renewed permissions, but with the rights that it has seen.
TEST_F(OwnListedPermissions, RenewedPermissionsWithMoreRights_KeepTheSession) {
  begin(true, {"t", "u"}, {"t"});
  put({next_});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
}

TEST_F(OwnListedPermissions, SessionWithoutAList_Ends) {
  begin(true);
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::session_outlived_documents));
}

TEST_F(OwnListedPermissions, APeerOfAnotherProduct_HasNoList) {
  begin(false);
  put({next_});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

}  // namespace
}  // namespace ddssec::access_control
