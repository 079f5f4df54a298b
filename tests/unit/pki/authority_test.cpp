#include "pki/authority.hpp"

#include <gtest/gtest.h>

#include "pki/key_agreement.hpp"
#include "pki/signature.hpp"
#include "pki/smime.hpp"
#include "pki/subject_name.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

class AuthorityOfKind : public testing::TestWithParam<KeySpec> {};
INSTANTIATE_TEST_SUITE_P(Keys, AuthorityOfKind,
                         testing::Values(KeySpec{KeyKind::ec_p256}, KeySpec{KeyKind::ec_p384},
                                         KeySpec{KeyKind::rsa, 2048}),
                         [](const auto& info) {
                           return std::string("Kind") + std::to_string(info.index);
                         });

TEST_P(AuthorityOfKind, IssuedCertificate_IsVerifiedByItsOwnFile) {
  const auto ca = make_ca("CN=Root,O=Example", GetParam());
  const auto leaf = make_leaf(ca, "CN=talker,O=Example", GetParam());
  EXPECT_EQ(leaf.certificate.subject(), "CN=talker,O=Example");
  EXPECT_EQ(leaf.certificate.subject_one_line(), "/O=Example/CN=talker");
  EXPECT_EQ(leaf.certificate.issuer(), "CN=Root,O=Example");
  EXPECT_EQ(leaf.certificate.key_algorithm(), leaf.key.algorithm());
  EXPECT_FALSE(leaf.certificate.is_ca());
  EXPECT_TRUE(ca.certificate().is_ca());
  EXPECT_TRUE(leaf.key.check_fits(leaf.certificate));
  EXPECT_CODE(leaf.key.check_fits(ca.certificate()), key_mismatch);
  const auto verifier = make_verifier({ca.certificate()});
  const auto proof = verifier.verify(leaf.certificate, kNow);
  ASSERT_TRUE(proof) << proof.error().to_sentence();
  EXPECT_EQ(proof->not_after(), kYear.not_after);
}

TEST_P(AuthorityOfKind, SignedDocument_Verifies) {
  const auto ca = make_ca("CN=Root,O=Example", GetParam());
  const auto file = ca.sign_document(as_bytes("<dds>\n</dds>\n"), kNow, test_random());
  ASSERT_TRUE(file) << file.error().to_sentence();
  const auto verifier = DocumentVerifier::make({ca.certificate()});
  ASSERT_TRUE(verifier);
  const auto document = verifier->verify(*file, kNow);
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(as_text(document->content()), "<dds>\r\n</dds>\r\n");
  EXPECT_EQ(document->signer(), ca.certificate());
}

TEST_P(AuthorityOfKind, SignedHandshake_Verifies) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca, "CN=talker", GetParam());
  const auto signature = sign(leaf.key, as_bytes("hello"));
  ASSERT_TRUE(signature) << signature.error().to_sentence();
  EXPECT_TRUE(verify(leaf.certificate, as_bytes("hello"), *signature));
  EXPECT_CODE(verify(leaf.certificate, as_bytes("hellp"), *signature), signature_invalid);
  EXPECT_CODE(verify(ca.certificate(), as_bytes("hello"), *signature), signature_invalid);
}

TEST_P(AuthorityOfKind, SignedRequest_IsCertified) {
  const auto ca = make_ca();
  const auto key = PrivateKey::generate(GetParam().kind, GetParam().bits);
  ASSERT_TRUE(key);
  const auto request = make_request(*key, "CN=a+OU=b,O=c");
  ASSERT_TRUE(request);
  const auto certificate = ca.sign_request(as_bytes(*request), kYear, test_random());
  ASSERT_TRUE(certificate) << certificate.error().to_sentence();
  EXPECT_TRUE(SubjectName::parse("O=c,OU=b+CN=a")->matches(*certificate));
  EXPECT_TRUE(key->check_fits(*certificate));
}

TEST(AuthorityDates, LastYearThatACertificateCanName_IsReached) {
  using namespace std::chrono;
  const WallTime end = sys_days(year(9999) / December / 30) + hours(23);
  const auto ca = Authority::create_root("CN=Long", {}, {kNow, end}, test_random());
  ASSERT_TRUE(ca) << ca.error().to_sentence();
  EXPECT_EQ(ca->certificate().not_after(), end);
  const auto leaf = ca->issue("CN=talker", {}, {kNow, end}, test_random());
  ASSERT_TRUE(leaf) << leaf.error().to_sentence();
  const auto verifier = make_verifier({ca->certificate()});
  EXPECT_TRUE(verifier.verify(leaf->certificate, end - hours(1)));
  EXPECT_CODE(verifier.verify(leaf->certificate, end + hours(1)), certificate_expired);
}

class Agreement : public testing::TestWithParam<KeyAgreementKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Agreement,
                         testing::Values(KeyAgreementKind::ecdh_p256, KeyAgreementKind::ecdh_p384,
                                         KeyAgreementKind::dh_modp_2048_256));

TEST_P(Agreement, BothSides_DeriveTheSame) {
  const auto a = EphemeralKey::generate(GetParam());
  const auto b = EphemeralKey::generate(GetParam());
  ASSERT_TRUE(a && b);
  for (const auto encoding : {PublicKeyEncoding::plain_integer, PublicKeyEncoding::der_integer}) {
    const auto secret_a = a->derive(*b->public_octets(encoding));
    const auto secret_b = b->derive(*a->public_octets(encoding));
    ASSERT_TRUE(secret_a) << secret_a.error().to_sentence();
    ASSERT_TRUE(secret_b);
    EXPECT_EQ(*secret_a, *secret_b);
    EXPECT_EQ(secret_a->size(), 32u);
  }
}

TEST(Reissue, NewCertificate_KeepsSubjectAndKeyAndHasANewSerialNumber) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca, "CN=talker+OU=x,O=Example");
  const Validity later{kNow, kNow + 24h};
  const auto again = ca.reissue(leaf.certificate, later, test_random());
  ASSERT_TRUE(again) << again.error().to_sentence();
  EXPECT_EQ(again->subject_digest(), leaf.certificate.subject_digest());
  EXPECT_NE(again->serial(), leaf.certificate.serial());
  EXPECT_EQ(again->not_after(), later.not_after);
  EXPECT_FALSE(again->is_ca());
  EXPECT_TRUE(leaf.key.check_fits(*again));
  EXPECT_TRUE(make_verifier({ca.certificate()}).verify(*again, kNow));
  const auto other = PrivateKey::generate(KeyKind::ec_p256);
  const auto rekeyed = ca.reissue(leaf.certificate, later, test_random(), &*other);
  ASSERT_TRUE(rekeyed);
  EXPECT_TRUE(other->check_fits(*rekeyed));
  EXPECT_CODE(leaf.key.check_fits(*rekeyed), key_mismatch);
}

TEST(Reissue, RenewedRoot_StillVouchesForWhatItIssued) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca);
  const auto renewed = ca.renewed({kNow, kNow + 1000 * 24h}, test_random());
  ASSERT_TRUE(renewed) << renewed.error().to_sentence();
  EXPECT_TRUE(renewed->is_ca());
  EXPECT_TRUE(renewed->is_self_issued());
  EXPECT_EQ(renewed->path_length(), ca.certificate().path_length());
  EXPECT_TRUE(make_verifier({*renewed}).verify(leaf.certificate, kNow));
  const auto middle = ca.subordinate("CN=Middle", {}, kYear, test_random());
  ASSERT_TRUE(middle);
  const auto middle_again = ca.reissue(middle->certificate(), kYear, test_random());
  ASSERT_TRUE(middle_again);
  EXPECT_EQ(middle_again->path_length(), 0);
  EXPECT_FALSE(middle_again->is_self_issued());
}

}  // namespace
}  // namespace ddssec::pki
