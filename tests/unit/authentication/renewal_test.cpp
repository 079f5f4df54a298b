// Certificates and keys that are renewed while a participant runs.
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "plugins/spi/session_facts.hpp"
#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {
namespace {

using std::chrono::days;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr auto kAlice = "CN=alice,O=Example";
constexpr pki::Validity kLater{kNow, kNow + days(500)};

/// It lives longer than what it issues.
const pki::Authority& long_lived_ca() {
  static const auto ca =
      make_ca("CN=Identity CA,O=Example", {}, {kNow - days(2), kNow + days(2000)});
  return ca;
}
const Identity& first_of_alice() {
  static const auto identity = make_identity(long_lived_ca(), kAlice);
  return identity;
}
const Identity& bob_of_it() {
  static const auto identity =
      make_identity(long_lived_ca(), "CN=bob,O=Example", {}, {kNow - 24h, kNow + days(1900)}, 1);
  return identity;
}

/// A certificate of Alice that begins now, with one of the keys of the tests.
Identity renewed(int key = 0, pki::Validity validity = kLater, std::string subject = kAlice,
                 KeySpec spec = {}, const pki::Authority& ca = long_lived_ca()) {
  return make_identity(ca, std::move(subject), spec, validity, key);
}

/// Alice has files; Bob has none.
class Renewal : public testing::Test {
 protected:
  explicit Renewal(const Identity& first = first_of_alice())
      : certificate_path_(folder_.write("cert.pem", first.certificate.pem())),
        key_path_(folder_.write("key.pem", pem_text(first.key))),
        pairing_(with_files(first), bob_of_it()) {}

  Identity with_files(Identity identity) const {
    set(identity.properties, property::kIdentityCertificate, "file:" + certificate_path_);
    set(identity.properties, property::kPrivateKey, "file:" + key_path_);
    return identity;
  }
  void put(const Identity& identity) {
    folder_.replace("cert.pem", identity.certificate.pem());
    folder_.replace("key.pem", pem_text(identity.key));
  }
  std::vector<IdentityHandle> look() {
    engine().clock.advance(5s);
    return engine()->expire();
  }
  /// As often as a host would in a quarter of a minute.
  std::vector<Code> codes_after_looking() {
    events().clear();
    for (int i = 0; i < 3; ++i) look();
    std::vector<Code> out;
    for (const auto& event : events()) out.push_back(event.error.code());
    return out;
  }
  /// It is not taken, and that is said once.
  void expect_refused(const Identity& identity, std::string_view field, std::string_view expected,
                      std::string_view found) {
    put(identity);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
    ASSERT_FALSE(events().empty());
    const auto& error = events().front().error;
    EXPECT_EQ(error.details().document, certificate_path_);
    EXPECT_EQ(error.details().field, field);
    EXPECT_EQ(error.details().expected, expected);
    EXPECT_EQ(error.details().found, found);
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
    EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  }
  /// c.id of a handshake that begins now, with a new peer.
  std::string presented() {
    Engine engine_of_carol{7};
    Participant carol(engine_of_carol,
                      make_identity(long_lived_ca(), "CN=carol,O=Example", {}, kYear, 2),
                      ++carols_);
    Two two(pairing_.a, carol);
    const auto request = two.request();
    EXPECT_TRUE(request);
    if (&two.low == &pairing_.a) return std::string(as_text(field(*request->message, "c.id")));
    const auto reply = two.reply(*request->message);
    EXPECT_TRUE(reply);
    return std::string(as_text(field(*reply->message, "c.id")));
  }
  Engine& engine() { return pairing_.first_engine; }
  std::vector<Event>& events() { return engine().events.events; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }

  const test::TemporaryFolder folder_;
  const std::string certificate_path_, key_path_;
  Pairing pairing_;
  std::uint8_t carols_ = 10;
};

// ---- what is taken

TEST_F(Renewal, CertificateOfTheSameKey_IsPresentedFromThenOn) {
  EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  const auto next = renewed();
  folder_.replace("cert.pem", next.certificate.pem());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  const auto& event = events().front();
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.proof, PeerProof::not_a_peer);
  EXPECT_EQ(event.guid, pairing_.a.guid.to_string());
  EXPECT_EQ(event.error.details().document, certificate_path_);
  EXPECT_EQ(event.error.details().found, to_string(kLater.not_after));
  EXPECT_EQ(presented(), next.certificate.pem());
  pairing_.expect_success();
}

TEST_F(Renewal, CertificateAndKey_AreTakenTogether) {
  const auto next = renewed(3);
  put(next);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  EXPECT_EQ(presented(), next.certificate.pem());
  pairing_.expect_success();
}

TEST_F(Renewal, CertificateBeforeItsKey_WaitsOneLookForIt) {
  const auto next = renewed(3);
  folder_.replace("cert.pem", next.certificate.pem());
  look();
  EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  folder_.replace("key.pem", pem_text(next.key));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  pairing_.expect_success();
}

TEST_F(Renewal, KeyBeforeItsCertificate_WaitsOneLookForIt) {
  const auto next = renewed(3);
  folder_.replace("key.pem", pem_text(next.key));
  look();
  EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  folder_.replace("cert.pem", next.certificate.pem());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  EXPECT_EQ(presented(), next.certificate.pem());
}

TEST_F(Renewal, KeyThatComesMuchLater_IsReportedOnceAndTaken) {
  const auto next = renewed(3);
  folder_.replace("cert.pem", next.certificate.pem());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  EXPECT_THAT(events().front().error.details().document, key_path_);
  EXPECT_THAT(events().front().error.to_sentence(), HasSubstr("does not belong"));
  folder_.replace("key.pem", pem_text(next.key));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
}

TEST_F(Renewal, KeyWithoutItsCertificate_IsReportedAndNotUsed) {
  folder_.replace("key.pem", pem_text(renewed(3).key));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  pairing_.expect_success();
}

TEST_F(Renewal, SameCertificateWrittenAgain_IsNoEvent) {
  put(first_of_alice());
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(Renewal, SecondRenewal_IsTakenToo) {
  put(renewed());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  const auto next = renewed(3, {kNow + 1s, kNow + days(600)});
  put(next);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  EXPECT_EQ(presented(), next.certificate.pem());
}

TEST_F(Renewal, KeyInTheProperties_StaysAndTheCertificateMustBeForIt) {
  auto identity = first_of_alice();
  set(identity.properties, property::kIdentityCertificate, "file:" + certificate_path_);
  Engine other{3};
  Participant alone(other, identity, 9);
  other.events.events.clear();
  const auto look_there = [&] {
    for (int i = 0; i < 3; ++i) {
      other.clock.advance(5s);
      other->expire();
    }
  };
  folder_.replace("cert.pem", renewed(3).certificate.pem());
  look_there();
  ASSERT_EQ(other.events.events.size(), 1u);
  EXPECT_EQ(other.events.events.back().error.code(), Code::identity_renewal_refused);
  folder_.replace("cert.pem", renewed().certificate.pem());
  look_there();
  EXPECT_EQ(other.events.events.back().error.code(), Code::identity_renewed);
}

TEST_F(Renewal, IntervalOfZero_MeansNever) {
  auto identity = with_files(first_of_alice());
  set(identity.properties, property::kFilesPollInterval, "0");
  Engine other{3};
  Participant alone(other, identity, 9);
  other.events.events.clear();
  put(renewed());
  other.clock.advance(60s);
  other->expire();
  EXPECT_THAT(other.events.events, IsEmpty());
}

// ---- what is not taken

TEST_F(Renewal, AnotherSubject_IsRefused) {
  expect_refused(renewed(0, kLater, "CN=alice,O=Other"), "subject", kAlice, "CN=alice,O=Other");
}

// The octets of the name count, not what is printed of them.
TEST_F(Renewal, SubjectInAnotherOrder_IsRefused) {
  expect_refused(renewed(0, kLater, "O=Example,CN=alice"), "subject", kAlice, "O=Example,CN=alice");
}

TEST_F(Renewal, AnotherKindOfKey_IsRefused) {
  const KeySpec p384{KeyKind::ec_p384};
  expect_refused(renewed(0, kLater, kAlice, p384), "key algorithm", "EC-prime256v1",
                 "EC-secp384r1");
}

TEST_F(Renewal, EarlierBegin_IsRefused) {
  const pki::Validity earlier{kYear.not_before - 1s, kLater.not_after};
  expect_refused(renewed(0, earlier), "notBefore", to_string(kYear.not_before) + " or later",
                 to_string(earlier.not_before));
}

TEST_F(Renewal, EarlierEnd_IsRefused) {
  const pki::Validity shorter{kNow, kYear.not_after - 1s};
  expect_refused(renewed(0, shorter), "notAfter", to_string(kYear.not_after) + " or later",
                 to_string(shorter.not_after));
}

TEST_F(Renewal, AnotherCa_IsRefused) {
  put(renewed(0, kLater, kAlice, {}, make_ca("CN=Other CA")));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  EXPECT_EQ(presented(), first_of_alice().certificate.pem());
}

TEST_F(Renewal, CertificateThatIsNotValidYet_IsTakenWhenItIs) {
  const auto next = renewed(0, {kNow + 60s, kLater.not_after});
  put(next);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  engine().clock.advance(60s);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  EXPECT_EQ(presented(), next.certificate.pem());
}

TEST_F(Renewal, RevokedCertificate_IsRefused) {
  const auto next = renewed();
  const auto list = folder_.write("crl.pem", pem({2, {next.certificate}}, long_lived_ca()));
  Engine other{3};
  Participant alone(other, with_list(with_files(first_of_alice()), "file:" + list), 9);
  put(next);
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->expire(), IsEmpty());
  }
  ASSERT_EQ(other.events.events.size(), 1u);
  EXPECT_EQ(other.events.events.back().error.code(), Code::identity_renewal_refused);
  EXPECT_THAT(other.events.events.back().error.to_sentence(), HasSubstr("was revoked"));
}

// A list that names the former certificate does not touch a participant that has a new one.
TEST_F(Renewal, ListWithTheFormerCertificate_DoesNotEndUs) {
  const auto list = folder_.write("crl.pem", pem({}, long_lived_ca()));
  Engine other{3};
  Participant alone(other, with_list(with_files(first_of_alice()), "file:" + list), 9);
  put(renewed());
  folder_.replace("crl.pem", pem({2, {first_of_alice().certificate}}, long_lived_ca()));
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->expire(), IsEmpty());
  }
}

TEST_F(Renewal, WhatIsNoCertificate_IsReportedOnceAndNothingIsLost) {
  for (const auto* text : {"", "nonsense", "-----BEGIN CERTIFICATE-----\nMII"}) {
    folder_.replace("cert.pem", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused)) << text;
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << text;
  }
  folder_.replace("cert.pem", std::string(70'000, 'x'));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  std::filesystem::remove(certificate_path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  std::filesystem::create_directory(certificate_path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  std::filesystem::remove(certificate_path_);
  ASSERT_EQ(::mkfifo(certificate_path_.c_str(), 0600), 0);
  EXPECT_THAT(codes_after_looking(), testing::Each(Code::identity_renewal_refused));
  pairing_.expect_success();
}

// A file that changes at each call is read once for each interval.
TEST_F(Renewal, FileThatKeepsChanging_CostsOneLookForEachInterval) {
  events().clear();
  for (int i = 0; i < 50; ++i) {
    folder_.replace("cert.pem", "nonsense " + std::to_string(i));
    engine().clock.advance(100ms);
    engine()->expire();
  }
  EXPECT_LE(events().size(), 1u);
}

// ---- ends

TEST_F(Renewal, OwnEnd_Moves) {
  const auto first = engine()->next_expiry();
  put(renewed());
  look();
  ASSERT_TRUE(first);
  EXPECT_EQ(engine()->next_expiry(), kLater.not_after);
  engine().clock.advance(kYear.not_after - kNow);
  EXPECT_THAT(look(), IsEmpty());
  engine().clock.advance(days(200));
  EXPECT_THAT(look(), Contains(pairing_.a.handle));
}

TEST_F(Renewal, CertificateThatComesTooLate_IsNotTaken) {
  engine().clock.advance(kYear.not_after - kNow);
  EXPECT_THAT(look(), Contains(pairing_.a.handle));
  put(renewed(0, {kNow, kNow + days(900)}));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_CODE(engine()->identity_token(pairing_.a.handle), identity_ended);
}

TEST_F(Renewal, CertificateOfTheLastSecond_IsTaken) {
  put(renewed(0, {kNow, kNow + days(900)}));
  engine().clock.advance(kYear.not_after - kNow + 10s);
  EXPECT_THAT(engine()->expire(), IsEmpty());
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
}

TEST_F(Renewal, Warnings_FollowTheNewEnd) {
  engine().clock.advance(days(340));
  engine()->expire();
  EXPECT_EQ(events().back().error.code(), Code::identity_ends_soon);
  put(renewed(0, {kNow + days(340), kNow + days(440)}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  engine().clock.advance(days(60));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  engine().clock.advance(days(15));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ends_soon));
}

/// Bob has a certificate that lives longer than Alice's first one.
class RenewalWithBob : public Renewal {
 protected:
  RenewalWithBob()
      : Renewal(make_identity(long_lived_ca(), kAlice, {}, {kNow - 24h, kNow + days(30)})) {}
  void SetUp() override { pairing_.expect_success(); }
};

TEST_F(RenewalWithBob, Session_EndsWithTheCertificateThatThePeerHasSeen) {
  put(renewed());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  engine().clock.advance(days(29));
  EXPECT_THAT(look(), IsEmpty());
  engine().clock.advance(days(1));
  events().clear();
  EXPECT_THAT(look(), ElementsAre(bob_at_alice()));
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events().front().error.code(), Code::session_outlived_documents);
  EXPECT_EQ(events().front().severity, Severity::informational);
  EXPECT_EQ(events().front().peer_subject, "CN=bob,O=Example");
  EXPECT_THAT(look(), IsEmpty()) << "ended twice";
}

TEST_F(RenewalWithBob, WithoutRenewal_EndIsOurs) {
  engine().clock.advance(days(31));
  events().clear();
  EXPECT_THAT(look(), ElementsAre(pairing_.a.handle, bob_at_alice()));
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events().front().error.code(), Code::identity_ended);
}

TEST_F(RenewalWithBob, PeerOnTheOtherSide_EndsUsAtTheSameTime) {
  put(renewed());
  look();
  auto& bobs = pairing_.second_engine;
  bobs.clock.advance(days(30) + 1s);
  const auto alice_at_bob =
      &pairing_.two.low == &pairing_.a ? pairing_.two.low_at_high : pairing_.two.high_at_low;
  EXPECT_THAT(bobs->expire(), ElementsAre(alice_at_bob));
}

// Fast DDS judges no certificate again during a session, and answers no handshake that begins later.
TEST_F(Renewal, SessionWithFastDds_GoesOnAfterTheFormerEnd) {
  pairing_.b.data = participant_data(pairing_.b.guid, &pairing_.b.token, kFastDds);
  pairing_.expect_success();
  put(renewed(0, {kNow, kNow + days(900)}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  engine().clock.advance(kYear.not_after - kNow + 1s);
  EXPECT_THAT(look(), testing::Not(Contains(pairing_.a.handle)));
}

TEST_F(Renewal, Credential_SaysWhatWasPresentedToWhom) {
  for (const auto& [vendor, keeps] : {std::pair(kCycloneDds, false), {kFastDds, true}}) {
    Pairing pairing;
    ASSERT_OK((*pairing.two.low.engine)
                  ->set_permissions_credential_and_token(
                      pairing.two.low.handle,
                      {.class_id = std::string(spi::class_id::kPermissionsCredential),
                       .properties = {{"dds.perm.cert", "a document"}}},
                      {}));
    auto& high = pairing.two.high;
    high.data = participant_data(high.guid, &high.token, vendor);
    const auto request = pairing.two.request();
    ASSERT_OK(request);
    const auto reply = pairing.two.reply(*request->message);
    ASSERT_OK(reply);
    pairing.expect_finish(*request, *reply);
    const auto credential =
        (*pairing.two.low.engine)->authenticated_peer_credential_token(request->handle);
    ASSERT_OK(credential);
    const auto facts = spi::session_facts_in(*credential);
    EXPECT_EQ(facts.presented_permissions, sha256(as_bytes("a document")));
    EXPECT_EQ(facts.peer_keeps_session, keeps);
    Writer sent(Endian::big);
    spi::write_token(sent, *credential);
    EXPECT_EQ(as_text(sent.take()).find("org.ddssec"), std::string_view::npos);
  }
}

// ---- handshakes under way

TEST_F(Renewal, HandshakeUnderWay_GoesOnWithWhatItBeganWith) {
  const auto request = pairing_.two.request();
  ASSERT_OK(request);
  const auto reply = pairing_.two.reply(*request->message);
  ASSERT_OK(reply);
  put(renewed(3));
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
  pairing_.expect_finish(*request, *reply);
}

/// Alice with a peer whose GUID is the higher or the lower one.
struct Chosen {
  Chosen(Participant& alice, bool alice_begins)
      : peer(engine, choose(alice, alice_begins), 20), two(alice, peer) {}
  static Identity choose(const Participant& alice, bool alice_begins) {
    for (int i = 0;; ++i) {
      auto identity = make_identity(long_lived_ca(), "CN=peer" + std::to_string(i), {}, kYear, 1);
      const auto guid = adjusted_guid(identity.certificate.subject_digest(), candidate(20));
      if ((alice.guid < guid) == alice_begins) return identity;
    }
  }
  Engine engine{7};
  Participant peer;
  Two two;
};

TEST_F(Renewal, RequestThatWasSent_IsRepeatedForAWhileAndThenMadeAnew) {
  Chosen with(pairing_.a, true);
  const auto first = with.two.request();
  ASSERT_OK(first);
  const auto next = renewed(3);
  put(next);
  engine().clock.advance(1s);
  engine()->expire();
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
  EXPECT_EQ(with.two.request()->handle, first->handle);
  engine().clock.advance(kPendingAge);
  const auto second = with.two.request();
  ASSERT_OK(second);
  EXPECT_NE(second->handle, first->handle);
  EXPECT_EQ(as_text(field(*second->message, "c.id")), next.certificate.pem());
  const auto reply = with.two.reply(*second->message);
  ASSERT_OK(reply);
  pairing_.expect_finish_of(with.two, *second, *reply);
}

TEST_F(Renewal, RequestThatComesAgain_IsAnsweredAnewAfterAWhile) {
  Chosen with(pairing_.a, false);
  const auto request = with.two.request();
  const auto first = with.two.reply(*request->message);
  ASSERT_OK(first);
  const auto next = renewed(3);
  put(next);
  engine().clock.advance(1s);
  engine()->expire();
  EXPECT_EQ(with.two.reply(*request->message)->handle, first->handle);
  engine().clock.advance(kPendingAge);
  const auto second = with.two.reply(*request->message);
  ASSERT_OK(second);
  EXPECT_NE(second->handle, first->handle);
  EXPECT_EQ(as_text(field(*second->message, "c.id")), next.certificate.pem());
  pairing_.expect_finish_of(with.two, *request, *second);
}

TEST_F(Renewal, PermissionsAndCertificate_AreNeverMixed) {
  const auto request = pairing_.two.request();
  const auto reply = pairing_.two.reply(*request->message);
  ASSERT_OK(reply);
  ASSERT_OK(engine()->set_permissions_credential_and_token(
      pairing_.a.handle,
      {std::string(spi::class_id::kPermissionsCredential), {{"dds.perm.cert", "<new/>"}}, {}}, {}));
  put(renewed(3));
  look();
  pairing_.expect_finish(*request, *reply);
}

// ---- the record for a person who asks

TEST_F(Renewal, Record_FollowsTheCertificateInForceAndWhatIsRefused) {
  const auto recorded = [&] {
    return test::recorded_document(engine().documents, "identity certificate");
  };
  EXPECT_EQ(recorded()["file"], certificate_path_);
  EXPECT_EQ(recorded()["since"], to_string(kNow));
  EXPECT_EQ(recorded()["in_force"][0]["subject"], first_of_alice().certificate.subject());
  EXPECT_EQ(recorded()["in_force"][0]["number"], first_of_alice().certificate.serial());

  put(renewed(3, kLater, "CN=mallory,O=Example"));
  codes_after_looking();
  const auto refused = recorded()["refused"];
  EXPECT_EQ(refused["name"], "identity_renewal_refused");
  EXPECT_EQ(refused["sentence"], events().front().error.to_sentence());
  EXPECT_EQ(refused["stands"], true);
  EXPECT_EQ(recorded()["in_force"][0]["number"], first_of_alice().certificate.serial());

  const auto next = renewed();
  put(next);
  codes_after_looking();
  EXPECT_EQ(recorded()["in_force"][0]["number"], next.certificate.serial());
  EXPECT_EQ(recorded()["in_force"][0]["until"], to_string(kLater.not_after));
  EXPECT_GT(recorded()["since"], to_string(kNow));
  EXPECT_EQ(recorded()["refused"]["stands"], false);
}

TEST_F(Renewal, RefusedCertificateThatIsTakenAway_NoLongerStands) {
  put(renewed(3, kLater, "CN=mallory,O=Example"));
  codes_after_looking();
  put(first_of_alice());
  codes_after_looking();
  const auto recorded = test::recorded_document(engine().documents, "identity certificate");
  EXPECT_EQ(recorded["refused"]["stands"], false);
  EXPECT_EQ(recorded["since"], to_string(kNow));
}

TEST_F(Renewal, Record_HasTheCaAndForgetsAParticipantThatLeaves) {
  const auto recorded = test::recorded_document(engine().documents, "identity CA");
  EXPECT_EQ(recorded["in_force"][0]["subject"], long_lived_ca().certificate().subject());
  EXPECT_EQ(recorded["in_force"][0]["until"], to_string(long_lived_ca().certificate().not_after()));
  ASSERT_OK(engine()->return_identity_handle(pairing_.a.handle));
  EXPECT_TRUE(test::recorded_document(engine().documents, "identity CA").is_null());
}

TEST_F(Renewal, Record_HasNoKey) {
  EXPECT_EQ(engine().documents.to_json().find("PRIVATE"), std::string::npos);
  EXPECT_EQ(engine().documents.to_json().find(key_path_), std::string::npos);
}

}  // namespace
}  // namespace ddssec::authentication
