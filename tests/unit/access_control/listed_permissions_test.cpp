// Which permissions of a renewal list extend those that a peer presented.
#include "plugins/access_control/listed_permissions.hpp"

#include <gmock/gmock.h>

#include "tests/unit/access_control/access_control_fixture.hpp"
#include "tests/unit/access_control/listed_peers.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST_F(ListedPeers, TheSameRightsThatEndEarlier_ChangeNothing) {
  put({document({"t"}, 0s, 10s)});
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
}

TEST_F(ListedPeers, TheSameRightsInTheFuture_CountOnceTheyBegin) {
  put({document({"t"}, 15s, 24h)});
  poll(10s);
  EXPECT_THAT(codes(), IsEmpty());
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
}

TEST_F(ListedPeers, SeveralDocuments_TheOneThatEndsLastCounts) {
  put({document({"t"}, 0s, 40s), document({"t"}, -1h, 12h), document({"t"}, 2s, 30s)});
  poll();
  EXPECT_EQ(plugin->next_expiry(), kNow + 12h);
}

// A list with other permissions for a peer that presents "t" and "u".
class OtherRights : public ListedPeers,
                    public testing::WithParamInterface<std::vector<std::string>> {
 protected:
  OtherRights() {
    (void)plugin->return_permissions_handle(peer_);
    meet(presented());
    log.all.clear();
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
    log.all.clear();
  }
};

TEST_P(OtherRights, RightsInAListedDocument_HaveNoEffect) {
  put({listed(0s, 24h)});
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
  EXPECT_THAT(poll(14s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_)) << "in time";
  EXPECT_THAT(codes(), ElementsAre(Code::grant_expired));
  meet(presented(-24h, 24h));
  EXPECT_THAT(codes(), IsEmpty());
  expect_as_presented();
}

TEST_P(OtherRights, EndedDocument_HasNoEffect) {
  put({listed(0s, 5s)});
  poll(6s);
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

TEST_P(OtherRights, RightsInAListedDocument_RefuseNothingThatThePeerShows) {
  put({listed(0s, 24h)});
  poll();
  EXPECT_TRUE(show(presented(-23h, 24h)));
  expect_as_presented();
  EXPECT_TRUE(show(document({"v"}, -22h, 24h)));
  EXPECT_TRUE(may_publish("v"));
  EXPECT_FALSE(may_publish("t"));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, OtherRights,
                         testing::Values(std::vector<std::string>{"t"},
                                         std::vector<std::string>{"v"},
                                         std::vector<std::string>{"*"},
                                         std::vector<std::string>{}));

// The peer gets none of the additional rights before it presents them.
TEST_F(ListedPeers, MoreRights_KeepThePeerWithTheRightsThatItPresented) {
  put({document({"t", "u"}, 0s, 24h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
  EXPECT_TRUE(may_publish("t"));
  EXPECT_FALSE(may_publish("v"));
  put({document({"u"}, 1s, 48h)});
  EXPECT_THAT(poll(5s), IsEmpty()) << "they count until their own end";
  meet(document({"t", "u"}, 0s, 24h));
  EXPECT_TRUE(may_publish("u"));
}

// The peer gets the additional rights as it does without a list: the session ends with the
// permissions that it presented, and a new one begins with the others.
TEST_F(ListedPeers, MoreRightsThatThePeerWants_DoNotKeepIt) {
  put({document({"t", "u"}, 0s, 24h)});
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_FALSE(may_publish("v")) << "neither gives it";
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_FALSE(may_publish("u"));
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
  meet(document({"t", "u"}, 0s, 24h));
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ListedPeers, MoreRightsThatThePeerWantedBefore_DoNotKeepIt) {
  EXPECT_FALSE(may_publish("u"));
  put({document({"t", "u"}, 0s, 24h)});
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
}

TEST_F(ListedPeers, TheSameRights_KeepAPeerThatWantsMore) {
  put({document({"t", "u"}, 0s, 24h)});
  poll();
  EXPECT_FALSE(may_publish("u"));
  put({document({"t", "u"}, 0s, 24h), document({"t"}, 0s, 12h)});
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

// Permissions with fewer rights replaced these, and must end in time.
TEST_F(ListedPeers, MoreRightsThatWereSignedEarlier_DoNotKeepThePeer) {
  signing_time = kNow - 1h;
  put({document({"t", "u"}, 0s, 24h)});
  signing_time = kNow;
  EXPECT_THAT(poll(20s), ElementsAre(peer_));
}

TEST_F(ListedPeers, MoreRightsThatEnd_EndThePeer) {
  put({document({"t", "u"}, 0s, 40s)});
  EXPECT_THAT(poll(39s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
}

// The end of the listed permissions must not lock the participant out for good.
TEST_F(ListedPeers, MoreRightsForAWhile_LockNoParticipantOut) {
  const auto own = document({"circle"}, -24h, 1000h);
  meet(own);
  put({document({"circle", "square"}, 0s, 30s)});
  poll();
  EXPECT_TRUE(may_publish("circle"));
  EXPECT_FALSE(may_publish("square")) << "the peer does not present it";
  poll(30s);
  log.all.clear();
  EXPECT_TRUE(may_publish("circle"));
  meet(own);
  EXPECT_TRUE(may_publish("circle"));
  EXPECT_THAT(codes(), IsEmpty());
}

// Rights that are given back count even though they begin before the listed permissions.
TEST_F(ListedPeers, RightsThatAreGivenBack_CountAtOnce) {
  const auto full = document({"t", "u"}, -24h, 1000h);
  const auto narrow = document({"t"}, 0s, 60s);
  put({narrow});
  poll();
  meet(narrow);
  EXPECT_FALSE(may_publish("u"));
  put({narrow, full});
  poll();
  meet(full);
  EXPECT_TRUE(may_publish("u"));
  poll(60s);
  EXPECT_TRUE(may_publish("u"));
  meet(full);
  EXPECT_TRUE(may_publish("u"));
}

TEST_F(ListedPeers, DocumentForAnotherDomain_ChangesNothing) {
  auto rule = publish_rule(true, {"t"});
  rule.domains.ranges = {{7, 7}};
  auto out = grant(kListener, {rule});
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_THAT(codes(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
  EXPECT_THAT(poll(15s), ElementsAre(peer_));
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

TEST_F(ListedPeers, ListedGrantWithAnExpression_ChangesNothing) {
  auto out = grant("CN=*,O=Example", {publish_rule(true, {"t"})});
  out.subject_is_expression = true;
  out.validity = {kNow, kNow + 24h};
  put({signed_permissions({out})});
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(peer_));
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

TEST_F(ListedPeers, DocumentOfAnotherSubject_IsOfNoUse) {
  put({document({"t"}, 0s, 24h, kTalker)});
  EXPECT_THAT(pass_the_end(), ElementsAre(peer_));
}

}  // namespace
}  // namespace ddssec::access_control
