// Permissions that are renewed while a participant runs.
#include "plugins/access_control/own_documents.hpp"

#include <sys/stat.h>

#include <gmock/gmock.h>

#include "base/rate_limited_sink.hpp"
#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"
#include "tests/unit/pki/untimed_signature.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class OwnDocumentsRenewal : public AccessControlTest {
 protected:
  void SetUp() override {
    ASSERT_TRUE(own_) << own_.error().to_sentence();
    log.all.clear();
  }

  // Returns permissions of the talker to publish and subscribe `names` in the given period.
  std::string document(std::vector<std::string> names, std::chrono::seconds from = -24h,
                       std::chrono::seconds until = 24h, const char* subject = kTalker) const {
    auto all = rule(true);
    all.publish = {topics(names)};
    all.subscribe = {topics(names)};
    auto out = grant(subject, {all});
    out.validity = {kNow + from, kNow + until};
    return signed_permissions({out});
  }
  spi::PropertyList with_file(spi::PropertyList properties) const {
    for (auto& one : properties)
      if (one.name == spi::property::kPermissions) one.value = "file:" + path_;
    return properties;
  }
  Result<spi::PermissionsHandle> from_file() {
    return plugin->validate_local_permissions(
        kLocalIdentity, 0,
        with_file(properties(signed_document(governance::to_xml(governance_document)), "")));
  }
  void expect_refused(const std::string& text, std::string_view why) {
    const auto before = presented();
    folder_.replace("permissions.p7s", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
    ASSERT_FALSE(log.all.empty());
    EXPECT_THAT(log.all.front().error.to_sentence(), HasSubstr(why));
    EXPECT_EQ(log.all.front().error.details().document, path_);
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
    EXPECT_EQ(presented(), before);
    EXPECT_EQ(plugin->renewals(*own_), 0u);
  }
  std::string presented() {
    const auto token = plugin->permissions_credential_token(*own_);
    return token ? token->properties.front().value : std::string();
  }
  bool may_publish(std::string_view topic) {
    return plugin->check_create_datawriter(*own_, 0, {.topic_name = topic}).has_value();
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.write("permissions.p7s", document({"t"}));
  Result<spi::PermissionsHandle> own_ = from_file();
};

TEST_F(OwnDocumentsRenewal, LaterDocument_IsInForceAndPresented) {
  EXPECT_FALSE(may_publish("u"));
  const auto next = document({"t", "u"}, 0s, 48h);
  folder_.replace("permissions.p7s", next);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  const auto& event = log.all.front();
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.error.details().document, path_);
  EXPECT_THAT(event.error.details().found,
              StartsWith(to_string(kNow + 48h) + ", sha256 " +
                         to_hex(sha256(as_bytes(next))).substr(0, 16)));
  EXPECT_TRUE(may_publish("u"));
  EXPECT_EQ(presented(), next);
  EXPECT_EQ(plugin->renewals(*own_), 1u);
  EXPECT_EQ(plugin->next_expiry(), kNow + 48h);
}

// A restart with this document would fail, and so would a renewal that begins with it.
TEST_F(OwnDocumentsRenewal, UnsignedDocument_ComesWithTheRemedyOfItsReason) {
  folder_.replace("permissions.p7s", "garbage");
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  ASSERT_FALSE(log.all.empty());
  EXPECT_EQ(log.all.front().error.hint(), info(Code::smime_not_multipart).hint);
}

TEST_F(OwnDocumentsRenewal, DocumentThatBeginsEarlier_IsToBeWrittenAnew) {
  folder_.replace("permissions.p7s", document({"t"}, -48h, 48h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  ASSERT_FALSE(log.all.empty());
  EXPECT_THAT(log.all.front().error.hint(), HasSubstr("ddssec permissions new"));
}

TEST_F(OwnDocumentsRenewal, SecondRenewal_IsTakenToo) {
  folder_.replace("permissions.p7s", document({"t"}, 0s, 48h));
  codes_after_looking();
  folder_.replace("permissions.p7s", document({"t"}, 10s, 72h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_EQ(plugin->renewals(*own_), 2u);
}

TEST_F(OwnDocumentsRenewal, DocumentThatGivesLess_CountsForNewEndpointsAndNewMatches) {
  const auto peer = remote(open_permissions(kListener));
  ASSERT_TRUE(peer);
  const spi::AccessControl::Match match{
      .remote_writes = false, .local = {.topic_name = "t"}, .remote = {}};
  EXPECT_TRUE(plugin->check_remote_match(*peer, match));
  folder_.replace("permissions.p7s", document({"u"}, 0s, 48h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_FALSE(may_publish("t"));
  EXPECT_REFUSED(plugin->check_remote_match(*peer, match), publish_not_allowed);
  const spi::AccessControl::Match reads{
      .remote_writes = true, .local = {.topic_name = "t"}, .remote = {}};
  EXPECT_REFUSED(plugin->check_remote_match(*peer, reads), subscribe_not_allowed);
  const spi::AccessControl::Match allowed{
      .remote_writes = true, .local = {.topic_name = "u"}, .remote = {}};
  EXPECT_TRUE(plugin->check_remote_match(*peer, allowed));
}

TEST_F(OwnDocumentsRenewal, EarlierEnd_IsTaken) {
  folder_.replace("permissions.p7s", document({"t"}, 0s, 1h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_EQ(plugin->next_expiry(), kNow + 1h);
}

TEST_F(OwnDocumentsRenewal, DocumentPutBetweenTheLastLookAndTheEnd_IsTakenByAllWithTheFile) {
  const auto second = from_file();
  ASSERT_TRUE(second);
  clock.advance(24h - 3s);
  EXPECT_THAT(plugin->poll(), IsEmpty());
  folder_.replace("permissions.p7s", document({"t", "u"}, 1h, 48h));
  clock.advance(3s);
  EXPECT_THAT(plugin->poll(), IsEmpty());
  EXPECT_TRUE(may_publish("u"));
  EXPECT_EQ(plugin->renewals(*second), 1u);
}

TEST_F(OwnDocumentsRenewal, EarlierBegin_IsRefusedAsARollBack) {
  expect_refused(document({"t", "u"}, -25h, 48h), to_string(kNow - 24h) + " or later");
}

// Documents that ddssec writes for one certificate begin at the same time, so the time of signing
// decides.
TEST_F(OwnDocumentsRenewal, DocumentThatWasSignedEarlier_IsRefusedAsARollBack) {
  const auto wide = document({"t", "u"});
  signing_time = kNow + 10s;
  const auto narrow = document({"u"});
  folder_.replace("permissions.p7s", narrow);
  ASSERT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  folder_.replace("permissions.p7s", wide);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  ASSERT_FALSE(log.all.empty());
  const auto& why = log.all.front().error;
  EXPECT_EQ(why.details().field, "signing time");
  EXPECT_EQ(why.details().expected, to_string(kNow + 10s) + " or later");
  EXPECT_EQ(why.details().found, to_string(kNow));
  EXPECT_THAT(why.hint(), HasSubstr("ddssec permissions sign"));
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "reported twice";
  EXPECT_EQ(presented(), narrow);
  EXPECT_FALSE(may_publish("t"));
}

TEST_F(OwnDocumentsRenewal, TheSameText_IsTakenOnceItIsSignedAgain) {
  for (const auto& names : {std::vector<std::string>{"u"}, {"t"}, {"u"}}) {
    signing_time += 1s;
    folder_.replace("permissions.p7s", document(names));
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
    EXPECT_EQ(may_publish("t"), names.front() == "t");
  }
  EXPECT_EQ(plugin->renewals(*own_), 3u);
}

TEST_F(OwnDocumentsRenewal, TwoDocumentsOfOneSecond_AreTakenInTheOrderInWhichTheyCome) {
  folder_.replace("permissions.p7s", document({"u"}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  folder_.replace("permissions.p7s", document({"t"}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(OwnDocumentsRenewal, DocumentWithoutASigningTime_FollowsOnlyOneWithoutIt) {
  const auto& ca = authorities().permissions_ca;
  const auto untimed = pki::without_signing_time(document({"t"}), {ca.certificate(), ca.key()});
  folder_.replace("permissions.p7s", untimed);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  ASSERT_FALSE(log.all.empty());
  EXPECT_EQ(log.all.front().error.details().found, "none");

  plugin->return_permissions_handle(*own_);
  own_ = from_file();
  ASSERT_TRUE(own_);
  folder_.replace("permissions.p7s", untimed + "\n");
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  folder_.replace("permissions.p7s", document({"u"}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_TRUE(may_publish("u"));
}

// Both hosts limit the rate of events. Both documents have the same end, but the second event must
// not be lost.
TEST_F(OwnDocumentsRenewal, TwoChangesWithinTheRateLimit_AreTwoEvents) {
  test::RecordedEvents passed;
  RateLimitedSink limited(passed, clock);
  for (const auto* topic : {"u", "v"}) {
    signing_time += 1s;
    folder_.replace("permissions.p7s", document({topic}));
    log.all.clear();
    poll();
    for (const auto& event : log.all) limited.raise(event);
  }
  EXPECT_EQ(passed.all.size(), 2u);
}

TEST_F(OwnDocumentsRenewal, AnotherCa_IsRefused) {
  const auto xml = governance::to_xml(governance::Permissions{.grants = {grant(kTalker, {})}});
  expect_refused(signed_by(authorities().other_ca, xml), "the permissions read before stay");
}

TEST_F(OwnDocumentsRenewal, AnotherSubject_IsRefused) {
  expect_refused(document({"t"}, 0s, 48h, kListener), kTalker);
}

TEST_F(OwnDocumentsRenewal, GrantThatIsNotValidYet_IsTakenWhenItIs) {
  folder_.replace("permissions.p7s", document({"t"}, 60s, 48h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  clock.advance(60s);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
}

TEST_F(OwnDocumentsRenewal, WhatIsNoDocument_IsReportedOnceAndNothingIsLost) {
  for (const auto& text : {std::string(), std::string("nonsense"), document({"t"}).substr(0, 500),
                           std::string(2'000'000, 'x')}) {
    folder_.replace("permissions.p7s", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
    EXPECT_THAT(codes_after_looking(), IsEmpty());
  }
  std::filesystem::remove(path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(OwnDocumentsRenewal, FileThatIsJustBeingWritten_IsNoEvent) {
  const auto next = document({"t"}, 0s, 48h);
  folder_.write("permissions.p7s", next.substr(0, 500));
  poll();
  folder_.write("permissions.p7s", next);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
}

TEST_F(OwnDocumentsRenewal, SameDocument_IsNoEvent) {
  folder_.replace("permissions.p7s", presented());
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(OwnDocumentsRenewal, DocumentThatComesTooLate_IsNotTaken) {
  clock.advance(24h);
  EXPECT_THAT(poll(), ElementsAre(*own_));
  folder_.replace("permissions.p7s", document({"t"}, 0s, 72h));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewal_refused));
  EXPECT_FALSE(may_publish("t"));
}

TEST_F(OwnDocumentsRenewal, DocumentOfTheLastSecond_IsTaken) {
  folder_.replace("permissions.p7s", document({"t"}, 0s, 72h));
  clock.advance(24h);
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_TRUE(may_publish("t"));
}

// A peer whose own permissions end long after those of the local participant.
class RenewalWithPeers : public OwnDocumentsRenewal {
 protected:
  spi::PermissionsHandle peer(const spi::SessionFacts& facts = {}) {
    auto long_lived = grant(kListener, {rule(true)});
    long_lived.validity.not_after = kNow + 100h;
    const auto handle = remote(signed_permissions({long_lived}), facts);
    EXPECT_TRUE(handle);
    return handle.value_or(spi::PermissionsHandle{});
  }
  // Returns the facts of a handshake in which this document was presented.
  static spi::SessionFacts that_presented(const std::string& text) {
    return {.presented_permissions = sha256(as_bytes(text))};
  }
  void renew(const std::string& text) {
    folder_.replace("permissions.p7s", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  }
  const std::string first_ = presented();
  const std::string second_ = document({"t"}, 0s, 72h);
};

TEST_F(RenewalWithPeers, HandshakeThatPresentedTheFormerDocument_EndsWithIt) {
  const auto before = peer(that_presented(first_));
  renew(second_);
  const auto meanwhile = peer(that_presented(first_));
  const auto later = peer(that_presented(second_));
  clock.advance(24h);
  EXPECT_THAT(poll(), ElementsAre(before, meanwhile));
  clock.advance(48h);
  EXPECT_THAT(poll(), testing::Contains(later)) << "with our own end";
}

TEST_F(RenewalWithPeers, FormerDocumentAfterManyRenewals_IsStillKnown) {
  renew(second_);
  std::string former;
  for (int i = 0; i < 20; ++i) {
    former = presented();
    renew(document({"t"}, std::chrono::seconds(1 + i), 72h + std::chrono::hours(1 + i)));
  }
  const auto of_former = peer(that_presented(former));
  const auto of_first = peer(that_presented(first_));
  const auto now = peer(that_presented(presented()));
  clock.advance(24h);
  EXPECT_THAT(poll(), ElementsAre(of_first));
  clock.advance(67h + 1min);
  EXPECT_THAT(poll(), ElementsAre(of_former)) << now.value;
}

TEST_F(RenewalWithPeers, AnotherVendorsAuthentication_PresentsTheFirstDocument) {
  renew(second_);
  const auto later = peer();
  clock.advance(24h);
  EXPECT_THAT(poll(), ElementsAre(later));
}

TEST_F(RenewalWithPeers, PeerThatKeepsItsSession_StaysAfterTheFormerEnd) {
  auto facts = that_presented(first_);
  facts.peer_keeps_session = true;
  peer(facts);
  renew(second_);
  clock.advance(25h);
  EXPECT_THAT(poll(), IsEmpty());
}

TEST_F(RenewalWithPeers, PeerThatHasSeenTheRenewedOne_StaysAfterTheFormerEnd) {
  const auto handle = peer(that_presented(first_));
  renew(second_);
  EXPECT_TRUE(plugin->note_presented(handle, that_presented(second_)));
  clock.advance(25h);
  EXPECT_THAT(poll(), IsEmpty());
}

TEST_F(RenewalWithPeers, Session_EndsWithTheDocumentThatThePeerHasSeen) {
  const auto handle = peer(that_presented(first_));
  renew(second_);
  peer(that_presented(second_));
  clock.advance(23h);
  EXPECT_THAT(poll(), IsEmpty());
  clock.advance(1h);
  log.all.clear();
  EXPECT_THAT(poll(), ElementsAre(handle));
  ASSERT_EQ(log.all.size(), 1u);
  EXPECT_EQ(log.all.front().error.code(), Code::session_outlived_documents);
  EXPECT_EQ(log.all.front().peer_subject, kListener);
  EXPECT_THAT(poll(), IsEmpty()) << "ended twice";
}

// A time before the former document began does not count as its end.
TEST_F(RenewalWithPeers, ClockThatGoesBackAfterARenewal_EndsNoSession) {
  const auto handle = peer(that_presented(first_));
  renew(second_);
  clock.set(kNow - 30 * 24h);
  EXPECT_THAT(poll(), IsEmpty());
  clock.set(kNow - 9000 * 24h);
  EXPECT_THAT(poll(), IsEmpty()) << "also before the permissions CA began";
  clock.set(kNow + 23h);
  EXPECT_THAT(poll(), IsEmpty());
  clock.advance(1h);
  EXPECT_THAT(poll(), ElementsAre(handle)) << "the end counts as before";
}

TEST_F(RenewalWithPeers, FormerGrantThatEnded_CountsBesideOneThatHasNotBegun) {
  auto later = grant(kTalker, {rule(true)}), brief = later;
  later.validity = {kNow + 50h, kNow + 60h};
  brief.validity = {kNow - 1h, kNow + 24h};
  const auto both = signed_permissions({later, brief});
  renew(both);
  const auto handle = peer(that_presented(both));
  renew(second_);
  clock.set(kNow + 23h);
  EXPECT_THAT(poll(), IsEmpty());
  clock.advance(1h);
  log.all.clear();
  EXPECT_THAT(poll(), ElementsAre(handle));
  ASSERT_EQ(log.all.size(), 1u);
  EXPECT_EQ(log.all.front().error.details().field, "<not_after>");
}

TEST_F(OwnDocumentsRenewal, Warnings_FollowTheNewEnd) {
  folder_.replace("permissions.p7s", document({"t"}, 0s, 24h * 10));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  clock.advance(24h * 9 + 12h);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_end_soon));
  folder_.replace("permissions.p7s", document({"t"}, 24h * 9, 24h * 69));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  clock.advance(24h * 53);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_end_soon));
}

TEST_F(OwnDocumentsRenewal, Record_FollowsThePermissionsInForceAndWhatIsRefused) {
  const auto recorded = [&] { return test::recorded_document(documents, "permissions"); };
  EXPECT_EQ(recorded()["file"], path_);
  EXPECT_EQ(recorded()["in_force"][0]["subject"], kTalker);
  EXPECT_EQ(recorded()["in_force"][0]["until"], to_string(kNow + 24h));
  EXPECT_EQ(recorded()["in_force"][0]["sha256"], to_hex(sha256(as_bytes(presented()))));

  folder_.replace("permissions.p7s", "broken");
  codes_after_looking();
  EXPECT_EQ(recorded()["refused"]["name"], "permissions_renewal_refused");
  EXPECT_EQ(recorded()["refused"]["sentence"], log.all.front().error.to_sentence());
  EXPECT_EQ(recorded()["refused"]["stands"], true);
  EXPECT_EQ(recorded()["refused"]["waits"], false);
  EXPECT_EQ(recorded()["since"], to_string(kNow));

  folder_.replace("permissions.p7s", document({"t"}, 1h, 48h));
  codes_after_looking();
  EXPECT_EQ(recorded()["refused"]["stands"], true);
  EXPECT_EQ(recorded()["refused"]["waits"], true) << "it is taken when it begins";

  folder_.replace("permissions.p7s", document({"t"}, 0s, 48h));
  codes_after_looking();
  EXPECT_EQ(recorded()["in_force"][0]["until"], to_string(kNow + 48h));
  EXPECT_GT(recorded()["since"], to_string(kNow));
  EXPECT_EQ(recorded()["refused"]["stands"], false);

  ASSERT_TRUE(plugin->return_permissions_handle(*own_));
  EXPECT_TRUE(recorded().is_null());
}

}  // namespace
}  // namespace ddssec::access_control
