// Inputs that harm some patch levels of OpenSSL are refused before OpenSSL reads them, on every
// patch level.
#include "pki/openssl_guards.hpp"

#include "pki/pki_access.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"
#include "pki_fixture.hpp"
#include "tests/support/hostile_pki.hpp"

namespace ddssec::pki {
namespace {

using test::PointName;
using testing::Test;

constexpr std::string_view kText = "<dds>\r\n</dds>\r\n";
constexpr int kForm = PKCS7_DETACHED | PKCS7_TEXT;

class DistributionPoints : public Test {
 protected:
  Result<Certificate> read(PointName form, int points, int issuer_entries) const {
    const auto pem = test::with_distribution_points(leaf_, form, points, issuer_entries);
    EXPECT_NE(pem, "") << take_openssl_reason();
    return Certificate::from_pem(as_bytes(pem));
  }
  // Returns the size of the issuer name that `read` makes.
  static std::size_t octets(int entries) {
    const auto ca = make_ca("CN=of any name");
    const auto pem = test::with_distribution_points(make_leaf(ca), PointName::full, 1, entries);
    const auto certificate = Certificate::from_pem(as_bytes(pem)).value();
    return static_cast<std::size_t>(
        i2d_X509_NAME(X509_get_issuer_name(impl_of(certificate).x509.get()), nullptr));
  }

  Credential leaf_ = make_leaf(make_ca());
};

TEST_F(DistributionPoints, ThousandCopiesOfALongIssuer_AreRefusedWithBothValues) {
  const auto bomb = read(PointName::relative, 1500, 200);  // 6 MB of names from 40 KB
  ASSERT_FALSE(bomb);
  EXPECT_CODE(bomb, certificate_distribution_points);
  const auto sentence = bomb.error().to_sentence();
  EXPECT_TRUE(sentence.contains("at most 65536 octets")) << sentence;
  EXPECT_TRUE(sentence.contains("for 1500 relative names")) << sentence;
}

TEST_F(DistributionPoints, PointsUpToTheBound_AreAllowedAndMoreAreNot) {
  const auto most = static_cast<int>(kMaxDistributionPointOctets / octets(10));
  const auto at_most = read(PointName::relative, most, 10);
  EXPECT_TRUE(at_most) << at_most.error().to_sentence();
  EXPECT_CODE(read(PointName::relative, most + 1, 10), certificate_distribution_points);
}

TEST_F(DistributionPoints, HonestCertificates_Pass) {
  for (const auto form :
       {PointName::full, PointName::relative, PointName::relative_to_named_issuer}) {
    const auto honest = read(form, 16, 8);
    EXPECT_TRUE(honest) << honest.error().to_sentence();
  }
  const auto many = read(PointName::full, 500, 20);  // full names are not copied
  EXPECT_TRUE(many) << many.error().to_sentence();
}

class Signatures : public Test {
 protected:
  // Returns the honest file with the changed signature.
  std::string file() {
    const auto begin = honest_.find("smime.p7s\"\n\n") + 12;
    std::string lines;
    const auto text = base64(test::der_of(pkcs7_.get()));
    for (std::size_t at = 0; at < text.size(); at += 64) lines += text.substr(at, 64) + "\n";
    return honest_.substr(0, begin) + lines + honest_.substr(honest_.find("\n--", begin));
  }
  Status accepted() {
    return verify_as_stock_products(as_bytes(file()), {ca_.certificate()}, kNow);
  }
  Result<SignedDocument> verified() {
    const auto verifier = DocumentVerifier::make({ca_.certificate()}).value();
    return verifier.verify(as_bytes(file()), kNow);
  }
  // Expects that both readers refuse it with the same code, and say what they found.
  void expect_bad_digest(std::string_view found) {
    ASSERT_TRUE(test::sign_attributes(pkcs7_.get())) << take_openssl_reason();
    EXPECT_CODE(accepted(), smime_message_digest);
    const auto strict = verified();
    ASSERT_FALSE(strict);
    EXPECT_CODE(strict, smime_message_digest);
    EXPECT_TRUE(strict.error().to_sentence().contains(found)) << strict.error().to_sentence();
  }
  void replace_digest(X509_ATTRIBUTE* by) {
    auto* attributes = test::attributes_of(pkcs7_.get());
    for (int i = sk_X509_ATTRIBUTE_num(attributes) - 1; i >= 0; --i) {
      X509_ATTRIBUTE* at = sk_X509_ATTRIBUTE_value(attributes, i);
      if (OBJ_obj2nid(X509_ATTRIBUTE_get0_object(at)) == NID_pkcs9_messageDigest)
        X509_ATTRIBUTE_free(sk_X509_ATTRIBUTE_delete(attributes, i));
    }
    if (by != nullptr) sk_X509_ATTRIBUTE_push(attributes, by);
  }

  Authority ca_ = make_ca("CN=Permissions CA");
  Credential self_{ca_.certificate(), ca_.key()};
  test::Pkcs7Ptr pkcs7_ = test::pkcs7_of(self_, kText, kForm);
  std::string honest_ = test::smime_of(pkcs7_.get(), kText, kForm);
  Bytes digest_ = Bytes(32, 7);
};

TEST_F(Signatures, HonestForm_PassesBothReaders) {
  EXPECT_TRUE(accepted());
  EXPECT_TRUE(verified());
  ASSERT_TRUE(test::sign_attributes(pkcs7_.get()));
  EXPECT_TRUE(accepted());
  EXPECT_TRUE(verified());
}

TEST_F(Signatures, SignaturesWithoutADigestAlgorithm_AreRefused) {
  auto* algorithms = pkcs7_->d.sign->md_algs;
  while (sk_X509_ALGOR_num(algorithms) > 0) X509_ALGOR_free(sk_X509_ALGOR_pop(algorithms));
  // Otherwise memory is freed twice, or the code is another one.
  EXPECT_CODE(accepted(), smime_digest_missing);
  EXPECT_CODE(verified(), smime_signature_invalid);
}

TEST_F(Signatures, SignaturesWithAMessageDigestOfAnotherType_AreRefused) {
  replace_digest(test::message_digest_of_type(V_ASN1_UTF8STRING, "digest", 6));
  expect_bad_digest("UTF8STRING");
  const Asn1IntegerPtr number(ASN1_INTEGER_new());
  ASN1_INTEGER_set(number.get(), 7);
  replace_digest(test::message_digest_of_type(V_ASN1_INTEGER, number.get(), -1));
  expect_bad_digest("INTEGER");
  replace_digest(test::message_digest_of_type(V_ASN1_NULL, nullptr, -1));
  expect_bad_digest("NULL");
}

TEST_F(Signatures, SignaturesWithoutOneMessageDigest_AreRefused) {
  const auto octets = [&] {
    return test::message_digest_of_type(V_ASN1_OCTET_STRING, digest_.data(), 32);
  };
  replace_digest(nullptr);
  expect_bad_digest("found 0 attributes");
  replace_digest(octets());
  sk_X509_ATTRIBUTE_push(test::attributes_of(pkcs7_.get()), octets());
  expect_bad_digest("found 2 attributes");
  X509_ATTRIBUTE* twice = octets();
  X509_ATTRIBUTE_set1_data(twice, V_ASN1_OCTET_STRING, digest_.data(), 32);
  replace_digest(twice);
  expect_bad_digest("found 2 values");
}

TEST_F(Signatures, CertificateOfManyDistributionPoints_IsRefused) {
  const auto pem = test::with_distribution_points(make_leaf(ca_), PointName::relative, 1500, 200);
  const BioPtr bio = bio_over(as_bytes(pem));
  const X509Ptr bomb(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  ASSERT_EQ(PKCS7_add_certificate(pkcs7_.get(), bomb.get()), 1);
  EXPECT_CODE(accepted(), certificate_distribution_points);
  EXPECT_TRUE(verified());  // the strict reader reads no certificate of the signature
}

}  // namespace
}  // namespace ddssec::pki
