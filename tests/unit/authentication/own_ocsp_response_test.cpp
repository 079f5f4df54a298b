// The local OCSP response: when it is read, sent and replaced.
#include <gmock/gmock.h>

#include "tests/support/recorded_document.hpp"
#include "tests/unit/authentication/ocsp_responses.hpp"

namespace ddssec::authentication {
namespace {

using testing::HasSubstr;

TEST(OwnOcsp, BesideTheCertificate_IsSent) {
  const test::TemporaryFolder folder;
  folder.replace("cert.pem", alice().certificate.pem());
  folder.replace("ocsp.der", std::string(as_text(response_about(alice().certificate))));
  auto identity = alice();
  set(identity.properties, spi::property::kIdentityCertificate,
      "file:" + folder.path() + "/cert.pem");
  const test::TemporaryFolder other;
  other.replace("bob.der", std::string(as_text(response_about(bob().certificate))));
  Pairing pairing(with_policy(identity, "hard"),
                  with_policy(with_file(bob(), other, "bob.der"), "hard"));
  pairing.expect_success();
  const auto state = test::recorded_document(pairing.first_plugin.documents, "OCSP response");
  EXPECT_THAT(state.dump(), HasSubstr(folder.path() + "/ocsp.der"));
  EXPECT_THAT(state.dump(), HasSubstr(to_string(kNow + 24h)));
}

TEST(OwnOcsp, LaterResponse_IsTaken) {
  const test::TemporaryFolder folder;
  Pairing pairing(with_file(alice(), folder), with_file(bob(), folder, "bob.der"));
  auto& two = pairing.two;
  const bool alice_begins = two.low.guid == pairing.a.guid;
  auto& plugin = alice_begins ? pairing.first_plugin : pairing.second_plugin;
  const auto& own = alice_begins ? alice() : bob();
  const auto before = two.request();
  ASSERT_OK(before);
  EXPECT_EQ(spi::find_binary_property(*before->message, "ocsp_status"), nullptr);
  const auto response = response_about(own.certificate);
  folder.replace(alice_begins ? "ocsp.der" : "bob.der", std::string(as_text(response)));
  plugin.clock.advance(6s);
  EXPECT_TRUE(plugin->poll().empty());
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_renewed), 1);
  // The request is the same, because it still waits for its reply.
  const auto request = two.request();
  ASSERT_OK(request);
  EXPECT_EQ(field(*request->message, "ocsp_status"), response);
  EXPECT_EQ(field(*request->message, "dh1"), field(*before->message, "dh1"));
}

struct OwnOcspFile : testing::Test {
  explicit OwnOcspFile() { set(identity.properties, spi::property::kFilesPollInterval, "1"); }
  void put(const Bytes& response) { folder.replace("ocsp.der", std::string(as_text(response))); }
  Result<spi::Authentication::LocalIdentity> start() {
    return plugin->validate_local_identity(0, identity.properties, candidate(1));
  }
  std::vector<IdentityHandle> poll() {
    plugin.clock.advance(1s);
    return plugin->poll();
  }
  const test::TemporaryFolder folder;
  Identity identity = with_file(alice(), folder);
  TestPlugin plugin;
};

TEST_F(OwnOcspFile, UnusableResponse_IsReportedOnceAndDoesNotKeepUsOut) {
  put(response_about(bob().certificate));
  ASSERT_OK(start());
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(poll().empty());
  ASSERT_EQ(count_of(plugin.events, Code::ocsp_response_refused), 1);
  EXPECT_THAT(plugin.events.all.back().error.to_sentence(), HasSubstr("another certificate"));
  put(response_about(alice().certificate));
  for (int i = 0; i < 5; ++i) poll();
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_renewed), 1);
}

TEST_F(OwnOcspFile, LinkToAMissingResponse_IsReportedOnceAndFollowedWhenItComes) {
  std::filesystem::create_symlink("fetched.der", folder.path() + "/ocsp.der");
  ASSERT_OK(start());
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(poll().empty());
  ASSERT_EQ(count_of(plugin.events, Code::ocsp_response_refused), 1);
  EXPECT_THAT(plugin.events.all.back().error.to_sentence(), HasSubstr("/ocsp.der"));
  folder.replace("fetched.der", std::string(as_text(response_about(alice().certificate))));
  for (int i = 0; i < 5; ++i) poll();
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_renewed), 1);
}

TEST_F(OwnOcspFile, MissingResponse_IsNoFault) {
  ASSERT_OK(start());
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(poll().empty());
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_refused), 0);
}

// A recorded answer of the responder must not take the place of a later one.
TEST_F(OwnOcspFile, ResponseEarlierThanTheOneInForce_IsRefused) {
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_GOOD, 0s, 48h));
  ASSERT_OK(start());
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_GOOD, -1h, 1h));
  for (int i = 0; i < 5; ++i) poll();
  ASSERT_EQ(count_of(plugin.events, Code::ocsp_response_refused), 1);
  EXPECT_THAT(plugin.events.all.back().error.to_sentence(), HasSubstr("thisUpdate"));
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_renewed), 0);
}

TEST_F(OwnOcspFile, EndOfTheResponse_IsReportedOnce) {
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_GOOD, 0s, 1h));
  ASSERT_OK(start());
  poll();
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_ended), 0);
  plugin.clock.advance(2h);
  for (int i = 0; i < 5; ++i) poll();
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_ended), 1);
}

TEST_F(OwnOcspFile, FutureResponse_IsRecordedAsOneThatWaits) {
  ASSERT_OK(start());
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_GOOD, 2h, 24h));
  poll();
  poll();
  const auto recorded = [&] {
    return test::recorded_document(plugin.documents, "OCSP response")["refused"];
  };
  EXPECT_EQ(recorded()["waits"], true);
  plugin.clock.advance(2h);
  poll();
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_response_renewed), 1);
  EXPECT_EQ(recorded()["stands"], false);
}

TEST_F(OwnOcspFile, RevokedStatus_EndsUs) {
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_REVOKED));
  EXPECT_CODE(start(), ocsp_revoked);
  put(response_about(alice().certificate));
  const auto us = start();
  ASSERT_OK(us);
  EXPECT_TRUE(poll().empty());
  put(response_about(alice().certificate, V_OCSP_CERTSTATUS_REVOKED));
  EXPECT_THAT(poll(), testing::ElementsAre(us->handle));
  EXPECT_EQ(count_of(plugin.events, Code::ocsp_revoked), 2);
  EXPECT_TRUE(poll().empty());
  EXPECT_CODE(plugin->identity_token(us->handle, spi::kStandardCiphers), ocsp_revoked);
}

TEST_F(OwnOcspFile, DataUri_IsRefused) {
  set(identity.properties, spi::property::kOcspResponse, "data:,x");
  EXPECT_CODE(start(), invalid_property);
}

}  // namespace
}  // namespace ddssec::authentication
