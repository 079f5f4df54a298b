#include "pki/ocsp.hpp"

#include <gmock/gmock.h>

#include "pki_fixture.hpp"
#include "tests/support/ocsp_responder.hpp"

namespace ddssec::pki {
namespace {

// A CA with a certificate, and the response that a test changes.
struct Ocsp : testing::Test {
  Authority ca = make_ca();
  Credential leaf = make_leaf(ca);
  test::OcspContent content{.answers = {{leaf.certificate, ca.certificate()}},
                            .signer = ca.certificate(),
                            .key = ca.key(),
                            .now = kNow};

  Result<GoodOcspStatus> judge(std::vector<Crl> crls = {}) const {
    return judge(test::ocsp_response(content), std::move(crls));
  }
  Result<GoodOcspStatus> judge(BytesView response, std::vector<Crl> crls = {}) const {
    return judge_ocsp(response, leaf.certificate,
                      make_verifier({ca.certificate()}, std::move(crls)), kNow);
  }
  void sign_with(const Credential& signer) {
    content.signer = signer.certificate;
    content.key = signer.key;
    content.sent = {signer.certificate};
  }
};

TEST_F(Ocsp, ResponseSignedByTheCa_IsAccepted) {
  const auto good = judge();
  ASSERT_OK(good);
  EXPECT_EQ(good->this_update(), kNow);
  EXPECT_EQ(good->until(), kNow + 24h);
  content.by_key = true;
  EXPECT_TRUE(judge());
}

TEST_F(Ocsp, ResponseWithSha256CertificateIds_IsAccepted) {
  content.answers.front().id_digest = EVP_sha256();
  EXPECT_TRUE(judge());
  content.answers.front().id_digest = EVP_sha384();
  EXPECT_TRUE(judge());
  content.answers.front().id_digest = EVP_md5();
  EXPECT_CODE(judge(), ocsp_other_certificate);
}

TEST_F(Ocsp, ResponseSignedByADelegate_IsAcceptedUntilTheDelegateExpires) {
  sign_with(test::ocsp_delegate(ca, {kNow - 1h, kNow + 2h}, test_random()));
  auto good = judge();
  ASSERT_OK(good);
  EXPECT_EQ(good->until(), kNow + 2h);
  content.by_key = true;
  EXPECT_TRUE(judge());
  content.sent.clear();
  EXPECT_CODE(judge(), ocsp_signer_wrong);
}

TEST_F(Ocsp, SignerWithoutTheUsage_IsRefused) {
  sign_with(test::ocsp_delegate(ca, kYear, test_random(), false));
  EXPECT_CODE(judge(), ocsp_signer_wrong);
  // The certificate that the response is about may not sign it either.
  sign_with(leaf);
  EXPECT_CODE(judge(), ocsp_signer_wrong);
}

TEST_F(Ocsp, DelegateOfAnotherCa_IsRefused) {
  const auto other = make_ca("CN=Other CA,O=Example");
  sign_with(test::ocsp_delegate(other, kYear, test_random()));
  EXPECT_CODE(judge(), ocsp_signer_wrong);
  // It is refused even if the other CA is trusted, and even if it has the name of ours.
  const auto both = make_verifier({ca.certificate(), other.certificate()});
  EXPECT_CODE(judge_ocsp(test::ocsp_response(content), leaf.certificate, both, kNow),
              ocsp_signer_wrong);
  const auto twin = make_ca();
  sign_with(test::ocsp_delegate(twin, kYear, test_random()));
  const auto twins = make_verifier({twin.certificate(), ca.certificate()});
  EXPECT_CODE(judge_ocsp(test::ocsp_response(content), leaf.certificate, twins, kNow),
              ocsp_signer_wrong);
}

TEST_F(Ocsp, DelegateThatEndedOrIsRevoked_IsRefused) {
  sign_with(test::ocsp_delegate(ca, {kNow - 48h, kNow - 1h}, test_random()));
  EXPECT_CODE(judge(), ocsp_signer_wrong);
  const auto delegate = test::ocsp_delegate(ca, kYear, test_random());
  sign_with(delegate);
  EXPECT_TRUE(judge());
  const std::array revoked = {delegate.certificate};
  const auto crl =
      ca.make_crl({.revoked = revoked, .this_update = kNow - 1h, .next_update = kNow + 24h});
  EXPECT_CODE(judge({crl.value()}), ocsp_signer_wrong);
}

TEST_F(Ocsp, AnotherCa_IsRefused) {
  const auto other = make_ca("CN=Other CA,O=Example");
  content.signer = other.certificate();
  content.key = other.key();
  EXPECT_CODE(judge(), ocsp_signer_wrong);
  // The signer has the same name and another key.
  const auto twin = make_ca();
  content.signer = twin.certificate();
  content.key = twin.key();
  EXPECT_CODE(judge(), ocsp_signature_invalid);
}

TEST_F(Ocsp, AboutAnotherCertificate_IsRefused) {
  const auto other = make_leaf(ca, "CN=other,O=Example");
  content.answers.front().certificate = other.certificate;
  EXPECT_CODE(judge(), ocsp_other_certificate);
  // The serial number is the same, but it is of a CA with the same name and another key.
  const auto twin = make_ca();
  content.answers = {{leaf.certificate, twin.certificate()}};
  content.signer = twin.certificate();
  content.key = twin.key();
  const auto both = make_verifier({ca.certificate(), twin.certificate()});
  EXPECT_CODE(judge_ocsp(test::ocsp_response(content), leaf.certificate, both, kNow),
              ocsp_other_certificate);
  content.answers.clear();
  EXPECT_CODE(judge(), ocsp_other_certificate);
}

TEST_F(Ocsp, RevokedCertificate_IsRefusedForEver) {
  auto& answer = content.answers.front();
  answer.status = V_OCSP_CERTSTATUS_REVOKED;
  const auto revoked = judge();
  EXPECT_CODE(revoked, ocsp_revoked);
  EXPECT_THAT(revoked.error().to_sentence(), testing::HasSubstr("keyCompromise"));
  answer.this_update = -48h;
  answer.next_update = -24h;
  EXPECT_CODE(judge(), ocsp_revoked);
}

TEST_F(Ocsp, UnknownCertificate_IsRefused) {
  content.answers.front().status = V_OCSP_CERTSTATUS_UNKNOWN;
  EXPECT_CODE(judge(), ocsp_unknown);
}

TEST_F(Ocsp, SeveralAnswers_TheWorstCounts) {
  auto other = content.answers.front();
  other.next_update = 12h;
  content.answers.push_back(other);
  const auto good = judge();
  ASSERT_OK(good);
  EXPECT_EQ(good->until(), kNow + 12h);
  content.answers.back().status = V_OCSP_CERTSTATUS_UNKNOWN;
  EXPECT_CODE(judge(), ocsp_unknown);
  content.answers.push_back(other);
  content.answers.back().status = V_OCSP_CERTSTATUS_REVOKED;
  EXPECT_CODE(judge(), ocsp_revoked);
}

TEST_F(Ocsp, OutsideItsTime_IsRefused) {
  auto& answer = content.answers.front();
  answer.this_update = 4min;
  EXPECT_TRUE(judge());
  answer.this_update = 6min;
  EXPECT_CODE(judge(), ocsp_not_yet_valid);
  answer.this_update = -24h;
  answer.next_update = -4min;
  EXPECT_TRUE(judge());
  answer.next_update = -6min;
  EXPECT_CODE(judge(), ocsp_expired);
  answer.next_update = -25h;
  EXPECT_CODE(judge(), ocsp_malformed);
}

TEST_F(Ocsp, ResponseWithoutAnEnd_CountsForADay) {
  auto& answer = content.answers.front();
  answer.next_update.reset();
  answer.this_update = -23h;
  const auto good = judge();
  ASSERT_OK(good);
  EXPECT_EQ(good->until(), kNow + 1h);
  answer.this_update = -25h;
  EXPECT_CODE(judge(), ocsp_expired);
}

TEST_F(Ocsp, SignedWithSha1_IsRefused) {
  content.digest = EVP_sha1();
  const auto response = test::ocsp_response(content);
  if (response.empty()) GTEST_SKIP() << "this OpenSSL does not sign with SHA-1";
  EXPECT_CODE(judge(response), ocsp_digest_too_weak);
}

TEST_F(Ocsp, ResponseWithACriticalExtension_IsRefused) {
  content.answers.front().is_critical = true;
  EXPECT_CODE(judge(), ocsp_malformed);
}

TEST_F(Ocsp, ResponseAboveALimit_IsRefused) {
  EXPECT_CODE(judge(Bytes(kMaxOcspOctets + 1, 0x30)), ocsp_too_large);
  content.answers.resize(kMaxOcspAnswers, content.answers.front());
  EXPECT_TRUE(judge());
  content.answers.push_back(content.answers.front());
  EXPECT_CODE(judge(), ocsp_too_large);
  content.answers.resize(1, content.answers.front());
  content.sent.assign(kMaxOcspCertificates + 1, leaf.certificate);
  EXPECT_CODE(judge(), ocsp_too_large);
}

TEST_F(Ocsp, ResponderThatDoesNotAnswer_IsRefused) {
  const auto refused = judge(test::ocsp_refusal(OCSP_RESPONSE_STATUS_TRYLATER));
  EXPECT_CODE(refused, ocsp_not_successful);
  EXPECT_THAT(refused.error().to_sentence(), testing::HasSubstr("trylater"));
}

TEST_F(Ocsp, CutAnywhereOrFollowedByOctets_IsRefused) {
  const auto whole = test::ocsp_response(content);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_CODE(judge(BytesView(whole).first(size)), ocsp_malformed);
  auto longer = whole;
  longer.push_back(0);
  EXPECT_CODE(judge(longer), ocsp_malformed);
}

TEST_F(Ocsp, ResponseWithOneBitFlipped_IsNeverGood) {
  // The algorithm of the signature is not signed. Its encoding only affects how the signature is
  // verified.
  const auto whole = test::ocsp_response(content);
  std::size_t good = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto flipped = whole;
    flipped[at] ^= 1;
    const auto judged = judge(flipped);
    if (!judged) continue;
    ++good;
    EXPECT_EQ(judged->until(), kNow + 24h) << at;
  }
  EXPECT_LE(good, 3u);
}

}  // namespace
}  // namespace ddssec::pki
