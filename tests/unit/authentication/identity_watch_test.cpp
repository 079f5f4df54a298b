// When renewed files are read and adopted, and what is reported about files that cannot be.
#include <sys/stat.h>

#include "tests/unit/authentication/renewal_fixture.hpp"

namespace ddssec::authentication {
namespace {

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
  poll();
  EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  folder_.replace("key.pem", pem_text(next.key));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewed));
  pairing_.expect_success();
}

TEST_F(Renewal, KeyBeforeItsCertificate_WaitsOneLookForIt) {
  const auto next = renewed(3);
  folder_.replace("key.pem", pem_text(next.key));
  poll();
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
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  other.events.all.clear();
  const auto look_there = [&] {
    for (int i = 0; i < 3; ++i) {
      other.clock.advance(5s);
      other->poll();
    }
  };
  folder_.replace("cert.pem", renewed(3).certificate.pem());
  look_there();
  ASSERT_EQ(other.events.all.size(), 1u);
  EXPECT_EQ(other.events.all.back().error.code(), Code::identity_renewal_refused);
  folder_.replace("cert.pem", renewed().certificate.pem());
  look_there();
  EXPECT_EQ(other.events.all.back().error.code(), Code::identity_renewed);
}

TEST_F(Renewal, IntervalOfZero_MeansNever) {
  auto identity = with_files(first_of_alice());
  set(identity.properties, property::kFilesPollInterval, "0");
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  other.events.all.clear();
  put(renewed());
  other.clock.advance(60s);
  other->poll();
  EXPECT_THAT(other.events.all, IsEmpty());
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
  folder_.replace("cert.pem", first_of_alice().certificate.pem());
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "a good file between two bad ones";
  std::filesystem::remove(certificate_path_);
  ASSERT_EQ(::mkfifo(certificate_path_.c_str(), 0600), 0);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
  pairing_.expect_success();
}

// A file that changes at each call is read once for each interval.
TEST_F(Renewal, FileThatKeepsChanging_CostsOneLookForEachInterval) {
  events().clear();
  for (int i = 0; i < 50; ++i) {
    folder_.replace("cert.pem", "nonsense " + std::to_string(i));
    plugin().clock.advance(100ms);
    plugin()->poll();
  }
  EXPECT_THAT(events(), testing::SizeIs(testing::AllOf(testing::Ge(2u), testing::Le(5u))));
}

}  // namespace
}  // namespace ddssec::authentication
