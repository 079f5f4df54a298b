// The record of the certificates in force, as `ddssec` shows it.
#include "tests/support/recorded_document.hpp"
#include "tests/unit/authentication/renewal_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST_F(Renewal, Record_FollowsTheCertificateInForceAndWhatIsRefused) {
  const auto recorded = [&] {
    return test::recorded_document(plugin().documents, "identity certificate");
  };
  EXPECT_EQ(recorded()["file"], certificate_path_);
  EXPECT_EQ(recorded()["since"], to_string(kNow));
  EXPECT_EQ(recorded()["state"], "current");
  EXPECT_EQ(recorded()["in_force"][0]["subject"], first_of_alice().certificate.subject());
  EXPECT_EQ(recorded()["in_force"][0]["number"], first_of_alice().certificate.serial());

  put(renewed(3, kLater, "CN=mallory,O=Example"));
  codes_after_looking();
  EXPECT_EQ(recorded()["state"], "refused");
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
  EXPECT_EQ(recorded()["state"], "current");
}

TEST_F(Renewal, CertificateThatBeginsInTheFuture_IsRecordedAsOneThatWaits) {
  const auto refused = [&] {
    return test::recorded_document(plugin().documents, "identity certificate")["refused"];
  };
  put(renewed(3, {kNow + 1h, kLater.not_after}));
  codes_after_looking();
  EXPECT_EQ(refused()["stands"], true);
  EXPECT_EQ(refused()["waits"], true);
  put(renewed(3, kLater, "CN=mallory,O=Example"));
  codes_after_looking();
  EXPECT_EQ(refused()["waits"], false) << "another subject never will be taken";
  put(renewed(3, {kNow + 1h, kLater.not_after}));
  codes_after_looking();
  plugin().clock.advance(1h);
  codes_after_looking();
  EXPECT_EQ(refused()["stands"], false);
  EXPECT_EQ(refused()["waits"], false);
}

TEST_F(Renewal, RefusedCertificateThatIsTakenAway_NoLongerStands) {
  put(renewed(3, kLater, "CN=mallory,O=Example"));
  codes_after_looking();
  put(first_of_alice());
  codes_after_looking();
  const auto recorded = test::recorded_document(plugin().documents, "identity certificate");
  EXPECT_EQ(recorded["refused"]["stands"], false);
  EXPECT_EQ(recorded["since"], to_string(kNow));
}

TEST_F(Renewal, Record_HasTheCaAndForgetsAParticipantThatLeaves) {
  const auto recorded = test::recorded_document(plugin().documents, "identity CA");
  EXPECT_EQ(recorded["in_force"][0]["subject"], long_lived_ca().certificate().subject());
  EXPECT_EQ(recorded["in_force"][0]["until"], to_string(long_lived_ca().certificate().not_after()));
  ASSERT_OK(plugin()->return_identity_handle(pairing_.a.handle));
  EXPECT_TRUE(test::recorded_document(plugin().documents, "identity CA").is_null());
}

TEST_F(Renewal, Record_HasNoKey) {
  EXPECT_EQ(plugin().documents.to_json().find("PRIVATE"), std::string::npos);
  EXPECT_EQ(plugin().documents.to_json().find(key_path_), std::string::npos);
}

}  // namespace
}  // namespace ddssec::authentication
