// Later permissions of peers, in a renewal list.
#include "pki/renewal_list.hpp"

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/fixture.hpp"

namespace ddssec::access_control {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

/// The talker is ours and has a list; the listener is the peer, whose permissions end 20 s from
/// now.
class ListedPeers : public AccessControlTest {
 protected:
  explicit ListedPeers(Options options = {}) {
    make(std::move(options));
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
  void put(const std::vector<std::string>& documents) {
    pki::RenewalList list;
    for (const auto& one : documents) list.permissions.push_back(to_bytes(as_bytes(one)));
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

TEST_F(ListedPeers, LaterPermissionsThatGiveTheSame_KeepThePeer) {
  put({document({"t"}, 0s, 24h)});
  EXPECT_THAT(look(), IsEmpty());
  ASSERT_EQ(log.events.size(), 1u);
  const auto& event = log.events.front();
  EXPECT_EQ(event.error.code(), Code::peer_permissions_listed);
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.peer_subject, kListener);
  EXPECT_EQ(event.error.details().found, to_string(kNow + 24h));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
  EXPECT_EQ(plugin->next_expiry(), kNow + 24h);
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

TEST_F(ListedPeers, PermissionsThatEndLater_AreTakenIfTheyBeginAtTheSameTime) {
  put({document({"t"}, -24h, 24h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(ListedPeers, OtherRightsThatBeginAtTheSameTime_AreNotLater) {
  put({document({"t", "u"}, -24h, 24h)});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
}

// As of documents for one certificate.
TEST_F(ListedPeers, OtherRightsThatBeginAtTheSameTime_CountIfTheyWereSignedLater) {
  auto out = grant(kListener, {publish_rule(true, {"u"})});
  out.validity = {kNow - 24h, kNow + 20s};
  const auto xml = governance::to_xml(governance::Permissions{.grants = {out}});
  const auto file =
      authorities().permissions_ca.sign_document(as_bytes(xml), kNow + 1s, test_random());
  ASSERT_TRUE(file);
  put({std::string(as_text(*file))});
  EXPECT_THAT(look(), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_replaced));
  meet(document({"t"}));
  EXPECT_FALSE(may_publish("u")) << "the list gives nothing more";
  EXPECT_FALSE(may_publish("t"));
}

TEST_F(ListedPeers, OtherRights_LastNoLongerThanThosePresented) {
  put({document({"t", "u"}, 0s, 24h)});
  look();
  meet(document({"t", "v"}));
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_FALSE(may_publish("v"));
  EXPECT_EQ(plugin->next_expiry(), kNow + 20s);
  EXPECT_THAT(pass_the_end(), Contains(peer_));
}

TEST_F(ListedPeers, LessRightsThatHaveEnded_StillBarTheFormerOnes) {
  const auto wide = document({"t", "u"}, -24h, 1000h);
  put({document({"t"}, 0s, 60s)});
  look();
  meet(wide);
  EXPECT_FALSE(may_publish("u"));
  EXPECT_THAT(pass_the_end(), Contains(peer_));
  log.events.clear();
  EXPECT_FALSE(remote(wide).has_value());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_replaced));
  meet(document({"u"}, 61s, 1000h));
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ListedPeers, LessRightsThatHadEndedAtTheStart_BarTheFormerOnes) {
  clock.advance(2min);
  put({document({"t"}, 0s, 60s)});
  look();
  EXPECT_FALSE(remote(document({"t", "u"}, -24h, 1000h)).has_value());
}

TEST_F(ListedPeers, TheSameRightsThatHaveEnded_EndNothing) {
  put({document({"t"}, 0s, 10s)});
  look();
  clock.advance(7s);
  meet(document({"t"}, -24h, 1000h));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, PermissionsForAnotherDomain_ChangeNothing) {
  auto rule = publish_rule(true, {"t"});
  rule.domains.ranges = {{7, 7}};
  auto out = grant(kListener, {rule});
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
  meet(document({"t"}));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, PermissionsWithAnExpression_ChangeNothing) {
  auto out = grant("CN=*,O=Example", {publish_rule(true, {"u"})});
  out.subject_is_expression = true;
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(look(), IsEmpty());
  meet(document({"t"}));
  EXPECT_TRUE(may_publish("t"));
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

TEST_F(ListedPeers, AListThatIsThereAtTheStart_CountsForTheFirstPeer) {
  (void)plugin->return_permissions_handle(own_);
  put({document({"t"}, 0s, 24h)});
  own_ = ours({}, "").value();
  meet(document({"t", "u"}, -24h, 24h));
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("u"));
}

TEST_F(ListedPeers, OlderPermissions_AreARollBack) {
  put({document({"t"}, -25h, 24h)});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

TEST_F(ListedPeers, OfAnotherSubject_AreOfNoUse) {
  put({document({"t"}, 0s, 24h, kTalker)});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

TEST_F(ListedPeers, LessRights_EndThePeerAtOnce) {
  meet(document({"t", "u"}));
  put({document({"t"}, 0s, 24h)});
  EXPECT_THAT(look(), Contains(peer_));
  EXPECT_THAT(codes(), Contains(Code::peer_permissions_replaced));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_FALSE(may_publish("t")) << "until it comes again";
}

TEST_F(ListedPeers, APeerThatComesAgain_IsJudgedByTheList) {
  put({document({"t"}, 0s, 24h)});
  look();
  log.events.clear();
  meet(document({"t", "u"}, -24h, 24h));
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("u"));
}

TEST_F(ListedPeers, APeerWithLaterPermissions_IsJudgedByThese) {
  put({document({"t"}, -1h, 24h)});
  look();
  log.events.clear();
  meet(document({"u"}, 0s, 24h));
  EXPECT_THAT(codes(), IsEmpty());
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ListedPeers, AFormerList_BringsNoFormerRightsBack) {
  put({document({"t"}, 0s, 24h)});
  look();
  put({document({"t", "u"}, -1h, 24h)});
  look();
  meet(document({"t", "u"}, -1h, 24h));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(ListedPeers, SignedByAnotherCa_IsOneEventAndChangesNothing) {
  put({document({"t"}, 0s, 24h)});
  look();
  log.events.clear();
  auto out = grant(kListener, {publish_rule(true, {"t", "u"})});
  out.validity = {kNow + 1s, kNow + 48h};
  const auto forged = signed_by(authorities().other_ca,
                                governance::to_xml(governance::Permissions{.grants = {out}}));
  put({forged});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_permissions_refused));
  EXPECT_FALSE(may_publish("u"));
  put({forged, document({"t"}, 0s, 72h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
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

// ---- a host whose peers show renewed permissions

class PatientHost : public ListedPeers {
 protected:
  PatientHost() : ListedPeers({.listed_rights_wait = 10s}) {}

  /// All begin at the same time, as those for one certificate.
  std::string signed_at(std::chrono::seconds when, std::vector<std::string> names) const {
    auto out = grant(kListener, {publish_rule(true, std::move(names))});
    out.validity = {kNow - 24h, kNow + 24h};
    const auto xml = governance::to_xml(governance::Permissions{.grants = {out}});
    const auto file =
        authorities().permissions_ca.sign_document(as_bytes(xml), kNow + when, test_random());
    return file ? std::string(as_text(*file)) : std::string();
  }
  Status show(const std::string& text) {
    return plugin->renew_remote_permissions(peer_, permissions_token(),
                                            credential(authorities().listener, text));
  }
};

TEST_F(PatientHost, OtherRights_EndThePeerAfterTheWait) {
  put({document({"u"}, 0s, 24h)});
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_THAT(look(), ElementsAre(peer_));
}

TEST_F(PatientHost, APeerThatShowsThemMeanwhile_Stays) {
  const auto next = document({"u"}, 0s, 24h);
  put({next});
  EXPECT_THAT(look(), IsEmpty());
  ASSERT_TRUE(plugin->renew_remote_permissions(peer_, permissions_token(),
                                               credential(authorities().listener, next)));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(PatientHost, APeerThatShowsFormerPermissions_IsNotGivenThemBack) {
  const auto wide = signed_at(0s, {"t", "u"});
  const auto narrow = signed_at(10s, {"t"});
  meet(wide);
  put({narrow});
  look();
  EXPECT_TRUE(show(narrow));
  log.events.clear();
  EXPECT_FALSE(show(wide));
  EXPECT_THAT(codes(), ElementsAre(Code::permissions_renewal_refused));
  EXPECT_FALSE(may_publish("u"));
  EXPECT_THAT(pass_the_end(), testing::Not(Contains(peer_)));
  EXPECT_FALSE(may_publish("u"));
}

TEST_F(PatientHost, APeerThatShowsFormerPermissions_GetsNoMoreTime) {
  const auto wide = signed_at(0s, {"t", "u"});
  meet(wide);
  put({signed_at(10s, {"t"})});
  look();
  EXPECT_FALSE(show(signed_at(5s, {"t", "u", "v"})));
  look();
  EXPECT_TRUE(show(wide)) << "that is in force";
  EXPECT_THAT(look(), Contains(peer_));
}

TEST_F(PatientHost, AfterItCameAgain_APeerIsNotGivenFormerPermissions) {
  const auto wide = signed_at(0s, {"t", "u"});
  put({signed_at(10s, {"t"})});
  look();
  meet(wide);
  EXPECT_FALSE(may_publish("u"));
  EXPECT_FALSE(show(signed_at(5s, {"t", "u"})) && may_publish("u"));
  EXPECT_TRUE(show(signed_at(20s, {"t", "u"})));
  EXPECT_TRUE(may_publish("u")) << "later ones count";
}

// ---- ours, which the peer has seen

class OwnListedPermissions : public ListedPeers {
 protected:
  /// Ours end first, and are renewed; the peer has seen the former ones.
  void begin(bool peer_reads_lists) {
    (void)plugin->return_permissions_handle(peer_);
    (void)plugin->return_permissions_handle(own_);
    const auto first = open(-24h, 20s);
    own_ = ours("file:" + folder_.write("permissions.p7s", first), "-").value();
    meet(open_permissions(kListener), {.presented_permissions = sha256(as_bytes(first)),
                                       .peer_keeps_session = false,
                                       .peer_reads_lists = peer_reads_lists});
    next_ = open(0s, 24h);
    folder_.replace("permissions.p7s", next_);
    look();
    log.events.clear();
  }
  std::string open(std::chrono::seconds from, std::chrono::seconds until) const {
    auto out = grant(kTalker, {publish_rule(true, {"*"})});
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
