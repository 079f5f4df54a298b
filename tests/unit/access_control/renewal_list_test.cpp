// Permissions of peers that a renewal list extends.
#include "pki/renewal_list.hpp"

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/fixture.hpp"

namespace ddssec::access_control {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

/// The talker is ours and has a list; the listener is the peer, whose permissions end 20 s from
/// now.
class ListedPeers : public AccessControlTest {
 protected:
  ListedPeers() {
    own_ = ours({}, "").value_or(spi::PermissionsHandle{});
    EXPECT_TRUE(own_);
    meet(document({"t"}));
    log.events.clear();
  }

  Result<spi::PermissionsHandle> ours(const std::string& permissions_uri, const std::string& text) {
    auto all = properties(signed_document(governance::to_xml(governance_document)),
                          text.empty() ? open_permissions(kTalker) : text);
    all.push_back({std::string(spi::property::kRenewalList), "file:" + path_, false});
    for (auto& one : all)
      if (!permissions_uri.empty() && one.name == spi::property::kPermissions)
        one.value = permissions_uri;
    return plugin->validate_local_permissions(kLocalIdentity, 0, all);
  }
  void meet(const std::string& text, const spi::SessionFacts& facts = {}) {
    peer_ = remote(text, facts).value_or(spi::PermissionsHandle{});
    EXPECT_TRUE(peer_);
  }
  /// The listener may publish `names`.
  std::string document(std::vector<std::string> names, std::chrono::seconds from = -24h,
                       std::chrono::seconds until = 20s, const char* subject = kListener) const {
    auto out = grant(subject, {publish_rule(true, std::move(names))});
    out.validity = {kNow + from, kNow + until};
    return signed_permissions({out});
  }
  Status show(const std::string& text) {
    return plugin->renew_remote_permissions(peer_, permissions_token(),
                                            credential(authorities().listener, text));
  }
  void put(const std::vector<std::string>& files) {
    pki::RenewalList list;
    for (const auto& one : files) list.permissions.push_back(to_bytes(as_bytes(one)));
    folder_.replace("renewed.pem", list.text().value());
  }
  std::vector<spi::PermissionsHandle> look(std::chrono::seconds after = 5s) {
    clock.advance(after);
    return plugin->expire();
  }
  std::vector<spi::PermissionsHandle> pass_the_end() {
    std::vector<spi::PermissionsHandle> ended;
    for (int i = 0; i < 16; ++i)
      for (const auto handle : look()) ended.push_back(handle);
    return ended;
  }
  std::vector<Code> codes() {
    std::vector<Code> out;
    for (const auto& event : log.events) out.push_back(event.error.code());
    log.events.clear();
    return out;
  }
  bool may_publish(std::string_view topic) {
    return plugin->check_remote_datawriter(peer_, 0, {.topic_name = topic}).has_value();
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/renewed.pem";
  spi::PermissionsHandle own_, peer_;
};

TEST_F(ListedPeers, TheSameRights_KeepThePeer) {
  put({document({"t"}, 0s, 12h)});
  EXPECT_THAT(look(), IsEmpty());
  ASSERT_EQ(log.events.size(), 1u);
  const auto& event = log.events.front();
  EXPECT_EQ(event.error.code(), Code::peer_permissions_listed);
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.peer_subject, kListener);
  EXPECT_EQ(event.error.details().found, to_string(kNow + 12h));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(log.events.size(), 1u);
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_EQ(plugin->next_expiry(), kNow + 12h);
}

TEST_F(ListedPeers, WithoutAList_ThePeerEndsInTime) {
  EXPECT_THAT(look(19s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
}

TEST_F(ListedPeers, AListOfTheLastSecond_Counts) {
  look(19s);
  put({document({"t"}, 0s, 24h)});
  EXPECT_THAT(look(1s), IsEmpty());
}

TEST_F(ListedPeers, AListThatIsThereAtTheStart_KeepsThePeer) {
  (void)plugin->return_permissions_handle(peer_);
  (void)plugin->return_permissions_handle(own_);
  put({document({"t"}, 0s, 24h)});
  own_ = ours({}, "").value();
  meet(document({"t"}));
  EXPECT_THAT(look(20s), IsEmpty());
}

TEST_F(ListedPeers, TheBeginOfTheSameRights_SaysNothing) {
  put({document({"t"}, -25h, 40s)});
  EXPECT_THAT(look(20s), IsEmpty());
  put({document({"t"}, -24h, 60s)});
  EXPECT_THAT(look(20s), IsEmpty());
  EXPECT_THAT(look(20s), ElementsAre(peer_));
}

TEST_F(ListedPeers, TheSameRightsThatEndEarlier_ChangeNothing) {
  put({document({"t"}, 0s, 10s)});
  EXPECT_THAT(look(19s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
}

TEST_F(ListedPeers, TheSameRightsInTheFuture_CountOnceTheyBegin) {
  put({document({"t"}, 15s, 24h)});
  look(10s);
  EXPECT_THAT(codes(), IsEmpty());
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
}

TEST_F(ListedPeers, TheSameRightsAfterTheEnd_AreTooLate) {
  put({document({"t"}, 21s, 24h)});
  EXPECT_THAT(look(20s), ElementsAre(peer_));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_FALSE(may_publish("t"));
}

TEST_F(ListedPeers, AnExtension_EndsWithItsOwnTimeInTheEvent) {
  put({document({"t"}, 0s, 40s)});
  EXPECT_THAT(look(39s), IsEmpty());
  log.events.clear();
  EXPECT_THAT(look(1s), ElementsAre(peer_));
  ASSERT_EQ(log.events.size(), 1u);
  EXPECT_EQ(log.events.front().error.code(), Code::grant_expired);
  EXPECT_THAT(log.events.front().error.to_sentence(), testing::HasSubstr(to_string(kNow + 40s)));
}

TEST_F(ListedPeers, AClockThatGoesBack_EndsNoExtension) {
  put({document({"t"}, 0s, 24h)});
  look(30s);
  clock.set(kNow + 1s);
  EXPECT_THAT(plugin->expire(), IsEmpty());
  clock.set(kNow - 1s);
  EXPECT_THAT(plugin->expire(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, OfSeveral_TheOneThatEndsLastCounts) {
  put({document({"t"}, 0s, 40s), document({"t"}, -1h, 12h), document({"t"}, 2s, 30s)});
  look();
  EXPECT_EQ(plugin->next_expiry(), kNow + 12h);
}

TEST_F(ListedPeers, AListThatNoLongerHasIt_LeavesAnExtensionUntilItsEnd) {
  put({document({"t"}, 0s, 60s)});
  look();
  put({document({"t"}, 0s, 24h, kTalker)});
  EXPECT_THAT(look(54s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_));
}

// It is signed, and holds until its end. What takes it away is the revocation of the certificate.
TEST_F(ListedPeers, ALaterEntryWithLessRights_LeavesThePeerUntilTheWideOneEnds) {
  meet(document({"t", "u"}));
  const auto wide = document({"t", "u"}, 0s, 60s);
  put({wide});
  look();
  put({wide, document({"t"}, 5s, 24h)});
  EXPECT_THAT(look(50s), Not(Contains(peer_)));
  EXPECT_TRUE(may_publish("u"));
  EXPECT_THAT(look(5s), Contains(peer_));
}

TEST_F(ListedPeers, AFormerListWithTheSameRights_GivesNoTimeBack) {
  const auto former = document({"t"}, 0s, 40s);
  put({former});
  look();
  put({document({"t"}, 0s, 60s)});
  look();
  put({former});
  EXPECT_THAT(look(49s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_));
}

// ---- other rights

/// What the list has for a peer that presents "t" and "u".
class OtherRights : public ListedPeers,
                    public testing::WithParamInterface<std::vector<std::string>> {
 protected:
  OtherRights() {
    (void)plugin->return_permissions_handle(peer_);
    meet(presented());
    log.events.clear();
  }
  std::string presented(std::chrono::seconds from = -24h, std::chrono::seconds until = 20s) const {
    return document({"t", "u"}, from, until);
  }
  std::string listed(std::chrono::seconds from, std::chrono::seconds until) const {
    if (!GetParam().empty()) return document(GetParam(), from, until);
    auto out = grant(kListener, {});
    out.validity = {kNow + from, kNow + until};
    return signed_permissions({out});
  }
  void expect_as_presented() {
    EXPECT_TRUE(may_publish("t"));
    EXPECT_TRUE(may_publish("u"));
    EXPECT_FALSE(may_publish("v"));
    log.events.clear();
  }
};

TEST_P(OtherRights, HaveNoEffect) {
  put({listed(0s, 24h)});
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
  EXPECT_THAT(look(14s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_)) << "in time";
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
  meet(presented(-24h, 24h));
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
}

TEST_P(OtherRights, ThatHaveEnded_HaveNoEffect) {
  put({listed(0s, 5s)});
  look(6s);
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
  meet(presented());
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
}

TEST_P(OtherRights, BesideTheSame_KeepThePeerByThese) {
  put({listed(0s, 48h), presented(-1h, 24h), listed(1s, 72h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
  expect_as_presented();
}

TEST_P(OtherRights, RefuseNothingThatThePeerShows) {
  put({listed(0s, 24h)});
  look();
  EXPECT_TRUE(show(presented(-23h, 24h)));
  expect_as_presented();
  EXPECT_TRUE(show(document({"v"}, -22h, 24h)));
  EXPECT_TRUE(may_publish("v"));
  EXPECT_FALSE(may_publish("t"));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, OtherRights,
                         testing::Values(std::vector<std::string>{"t"},
                                         std::vector<std::string>{"t", "u", "v"},
                                         std::vector<std::string>{"v"},
                                         std::vector<std::string>{"*"},
                                         std::vector<std::string>{}));

// Before, the end of the listed ones locked the participant out for good.
TEST_F(ListedPeers, MoreRightsForAWhile_LockNoParticipantOut) {
  const auto own = document({"circle"}, -24h, 1000h);
  meet(own);
  put({document({"circle", "square"}, 0s, 30s)});
  look();
  EXPECT_TRUE(may_publish("circle"));
  EXPECT_FALSE(may_publish("square")) << "the peer does not present it";
  look(30s);
  log.events.clear();
  EXPECT_TRUE(may_publish("circle"));
  meet(own);
  EXPECT_TRUE(may_publish("circle"));
  EXPECT_THAT(codes(), IsEmpty());
}

// Before, rights that were given back had no effect as long as they began before the listed ones.
TEST_F(ListedPeers, RightsThatAreGivenBack_CountAtOnce) {
  const auto full = document({"t", "u"}, -24h, 1000h);
  const auto narrow = document({"t"}, 0s, 60s);
  put({narrow});
  look();
  meet(narrow);
  EXPECT_FALSE(may_publish("u"));
  put({narrow, full});
  look();
  meet(full);
  EXPECT_TRUE(may_publish("u"));
  look(60s);
  EXPECT_TRUE(may_publish("u"));
  meet(full);
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ListedPeers, ForAnotherDomain_ChangeNothing) {
  auto rule = publish_rule(true, {"t"});
  rule.domains.ranges = {{7, 7}};
  auto out = grant(kListener, {rule});
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
  EXPECT_THAT(look(15s), ElementsAre(peer_));
}

TEST_F(ListedPeers, ARuleForAnotherDomain_IsNoOtherRight) {
  auto other = publish_rule(true, {"x"});
  other.domains.ranges = {{7, 7}};
  auto out = grant(kListener, {publish_rule(true, {"t"}), other});
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, WithAnExpression_ChangeNothing) {
  auto out = grant("CN=*,O=Example", {publish_rule(true, {"t"})});
  out.subject_is_expression = true;
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(look(19s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(peer_));
}

TEST_F(ListedPeers, AnExpressionThatIsPresented_IsExtendedByTheNameAlone) {
  (void)plugin->return_permissions_handle(peer_);
  auto out = grant("CN=*,O=Example", {publish_rule(true, {"t"})});
  out.subject_is_expression = true;
  out.validity = {kNow - 24h, kNow + 20s};
  meet(signed_permissions({out}));
  put({document({"t"}, 0s, 24h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(ListedPeers, OfAnotherSubject_AreOfNoUse) {
  put({document({"t"}, 0s, 24h, kTalker)});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

// ---- what a peer shows within its session

TEST_F(ListedPeers, ShownPermissionsThatBeginBeforeTheExtension_AreTaken) {
  put({document({"t"}, 0s, 24h)});
  look();
  EXPECT_TRUE(show(document({"t"}, -23h, 60s)));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(ListedPeers, ShownPermissionsWithOtherRights_AreNotExtendedByTheFormer) {
  put({document({"t"}, 0s, 24h)});
  look();
  EXPECT_TRUE(show(document({"u"}, -23h, 60s)));
  EXPECT_TRUE(may_publish("u"));
  EXPECT_FALSE(may_publish("t"));
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

// ---- lists that cannot be used

TEST_F(ListedPeers, SignedByAnotherCa_IsOneEventAndChangesNothing) {
  put({document({"t"}, 0s, 12h)});
  look();
  log.events.clear();
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

// Authentication reports such a list.
TEST_F(ListedPeers, AListThatCannotBeRead_ChangesNothing) {
  put({document({"t"}, 0s, 24h)});
  look();
  log.events.clear();
  folder_.replace("renewed.pem", "garbage");
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(log.events, IsEmpty());
}

// ---- ours, which the peer has seen

class OwnListedPermissions : public ListedPeers {
 protected:
  /// Ours end first, and are renewed; the peer has seen the former ones.
  void begin(bool peer_reads_lists, const char* next_topic = "*") {
    (void)plugin->return_permissions_handle(peer_);
    (void)plugin->return_permissions_handle(own_);
    const auto first = open(-24h, 20s);
    own_ = ours("file:" + folder_.write("permissions.p7s", first), "-").value();
    meet(open_permissions(kListener), {.presented_permissions = sha256(as_bytes(first)),
                                       .peer_keeps_session = false,
                                       .peer_reads_lists = peer_reads_lists});
    next_ = open(0s, 24h, next_topic);
    folder_.replace("permissions.p7s", next_);
    look();
    log.events.clear();
  }
  std::string open(std::chrono::seconds from, std::chrono::seconds until,
                   const char* topic = "*") const {
    auto out = grant(kTalker, {publish_rule(true, {topic})});
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

// The peer does not go by them.
TEST_F(OwnListedPermissions, RenewedPermissionsWithOtherRights_EndTheSession) {
  begin(true, "t");
  put({next_});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::session_outlived_documents));
}

TEST_F(OwnListedPermissions, WithoutAList_TheSessionEnds) {
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
