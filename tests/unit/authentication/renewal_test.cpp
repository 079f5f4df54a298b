// Which renewed certificates are refused, and what changes with one that is adopted: ends,
// sessions, warnings.
#include "tests/support/printable_subject.hpp"
#include "tests/unit/authentication/renewal_fixture.hpp"

namespace ddssec::authentication {
namespace {

// ---- what is refused

TEST_F(Renewal, AnotherSubject_IsRefused) {
  expect_refused(renewed(0, kLater, "CN=alice,O=Other"), "subject", kAlice, "CN=alice,O=Other");
}

// Names are compared by their octets, not by their printed form.
TEST_F(Renewal, SubjectInAnotherOrder_IsRefused) {
  expect_refused(renewed(0, kLater, "O=Example,CN=alice"), "subject", kAlice, "O=Example,CN=alice");
}

// A CA on Go's crypto/x509 writes a PrintableString. The GUID depends on the octets.
TEST_F(Renewal, SubjectInAnotherStringType_IsRefusedWithBothTypes) {
  auto identity = renewed();
  identity.certificate = test::with_printable(identity.certificate, "alice");
  expect_refused(identity, "subject", "CN=UTF8STRING:alice,O=UTF8STRING:Example",
                 "CN=PRINTABLESTRING:alice,O=UTF8STRING:Example");
  EXPECT_THAT(events().front().error.hint(), HasSubstr("start the participant again"));
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
  plugin().clock.advance(60s);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  EXPECT_EQ(presented(), next.certificate.pem());
}

TEST_F(Renewal, RevokedCertificate_IsRefused) {
  const auto next = renewed();
  const auto list = folder_.write("crl.pem", pem({2, {next.certificate}}, long_lived_ca()));
  TestPlugin other{3};
  Participant alone(other, with_list(with_files(first_of_alice()), "file:" + list), 9);
  put(next);
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->poll(), IsEmpty());
  }
  ASSERT_EQ(other.events.all.size(), 1u);
  EXPECT_EQ(other.events.all.back().error.code(), Code::identity_renewal_refused);
  EXPECT_THAT(other.events.all.back().error.to_sentence(), HasSubstr("was revoked"));
}

// A list that names the former certificate does not affect a participant that has a new one.
TEST_F(Renewal, ListWithTheFormerCertificate_DoesNotEndUs) {
  const auto list = folder_.write("crl.pem", pem({}, long_lived_ca()));
  TestPlugin other{3};
  Participant alone(other, with_list(with_files(first_of_alice()), "file:" + list), 9);
  put(renewed());
  folder_.replace("crl.pem", pem({2, {first_of_alice().certificate}}, long_lived_ca()));
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->poll(), IsEmpty());
  }
}

// ---- ends

TEST_F(Renewal, OwnEnd_Moves) {
  const auto first = plugin()->next_expiry();
  put(renewed());
  poll();
  ASSERT_TRUE(first);
  EXPECT_EQ(plugin()->next_expiry(), kLater.not_after);
  plugin().clock.advance(kYear.not_after - kNow);
  EXPECT_THAT(poll(), IsEmpty());
  plugin().clock.advance(days(200));
  EXPECT_THAT(poll(), Contains(pairing_.a.handle));
}

TEST_F(Renewal, CertificateThatComesTooLate_IsNotTaken) {
  plugin().clock.advance(kYear.not_after - kNow);
  EXPECT_THAT(poll(), Contains(pairing_.a.handle));
  put(renewed(0, {kNow, kNow + days(900)}));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_CODE(plugin()->identity_token(pairing_.a.handle), identity_ended);
}

TEST_F(Renewal, CertificateOfTheLastSecond_IsTaken) {
  put(renewed(0, {kNow, kNow + days(900)}));
  plugin().clock.advance(kYear.not_after - kNow + 10s);
  EXPECT_THAT(plugin()->poll(), IsEmpty());
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
}

TEST_F(Renewal, Warnings_FollowTheNewEnd) {
  plugin().clock.advance(days(340));
  plugin()->poll();
  EXPECT_EQ(events().back().error.code(), Code::identity_ends_soon);
  put(renewed(0, {kNow + days(340), kNow + days(440)}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  plugin().clock.advance(days(60));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  plugin().clock.advance(days(15));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ends_soon));
}

// Bob has a certificate that lives longer than Alice's first one.
class RenewalWithBob : public Renewal {
 protected:
  RenewalWithBob()
      : Renewal(make_identity(long_lived_ca(), kAlice, {}, {kNow - 24h, kNow + days(30)})) {}
  void SetUp() override { pairing_.expect_success(); }
};

TEST_F(RenewalWithBob, Session_EndsWithTheCertificateThatThePeerHasSeen) {
  put(renewed());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  plugin().clock.advance(days(29));
  EXPECT_THAT(poll(), IsEmpty());
  plugin().clock.advance(days(1));
  events().clear();
  EXPECT_THAT(poll(), ElementsAre(bob_at_alice()));
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events().front().error.code(), Code::session_outlived_documents);
  EXPECT_EQ(events().front().severity, Severity::informational);
  EXPECT_EQ(events().front().peer_subject, "CN=bob,O=Example");
  EXPECT_THAT(poll(), IsEmpty()) << "ended twice";
}

TEST_F(RenewalWithBob, OwnCertificateWithoutRenewal_EndsItsSessions) {
  plugin().clock.advance(days(31));
  events().clear();
  EXPECT_THAT(poll(), ElementsAre(pairing_.a.handle, bob_at_alice()));
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events().front().error.code(), Code::identity_ended);
}

TEST_F(RenewalWithBob, PeerOnTheOtherSide_EndsUsAtTheSameTime) {
  put(renewed());
  poll();
  auto& bobs = pairing_.second_plugin;
  bobs.clock.advance(days(30) + 1s);
  const auto alice_at_bob =
      &pairing_.two.low == &pairing_.a ? pairing_.two.low_at_high : pairing_.two.high_at_low;
  EXPECT_THAT(bobs->poll(), ElementsAre(alice_at_bob));
}

// Fast DDS judges no certificate again during a session, and answers no handshake that begins
// later.
TEST_F(Renewal, SessionWithFastDds_GoesOnAfterTheFormerEnd) {
  pairing_.b.data = participant_data(pairing_.b.guid, &pairing_.b.token, kFastDds);
  pairing_.expect_success();
  put(renewed(0, {kNow, kNow + days(900)}));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  plugin().clock.advance(kYear.not_after - kNow + 1s);
  EXPECT_THAT(poll(), testing::Not(Contains(pairing_.a.handle)));
}

}  // namespace
}  // namespace ddssec::authentication
