#include "pki/smime_diagnosis.hpp"

#include <algorithm>

#include <openssl/pkcs7.h>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki/smime.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kDocument = "<dds>\r\n</dds>\r\n";

// A document that OpenSSL signed in an unusual form.
class OddDocument {
 public:
  OddDocument(const Credential& signer, int flags) {
    const BioPtr data = bio_over(as_bytes(kDocument));
    pkcs7_.reset(PKCS7_sign(impl_of(signer.certificate).x509.get(), impl_of(signer.key).pkey.get(),
                            nullptr, data.get(), flags));
    EXPECT_TRUE(pkcs7_) << take_openssl_reason();
    const BioPtr again = bio_over(as_bytes(kDocument));
    const BioPtr out(BIO_new(BIO_s_mem()));
    SMIME_write_PKCS7(out.get(), pkcs7_.get(), again.get(), flags);
    smime_ = std::string(as_text(bio_octets(out)));
  }

  const std::string& smime() const { return smime_; }
  std::string pem() const {
    const BioPtr out(BIO_new(BIO_s_mem()));
    PEM_write_bio_PKCS7(out.get(), pkcs7_.get());
    return std::string(as_text(bio_octets(out)));
  }
  std::string der() const {
    const BioPtr out(BIO_new(BIO_s_mem()));
    i2d_PKCS7_bio(out.get(), pkcs7_.get());
    return std::string(as_text(bio_octets(out)));
  }

 private:
  std::unique_ptr<PKCS7, Deleter<PKCS7_free>> pkcs7_;
  std::string smime_;
};

class SmimeDiagnosis : public testing::Test {
 protected:
  DocumentForm examine(std::string_view file) const { return examine_document(as_bytes(file)); }
  Status verified(std::string_view file, WallTime now = kNow) const {
    return verify_as_stock_products(as_bytes(file), {ca_.certificate()}, now);
  }
  std::string signed_by(const Credential& who) const {
    return std::string(as_text(*sign_document(who, as_bytes(kDocument), kNow, test_random())));
  }

  Authority ca_ = make_ca("CN=Permissions CA");
  Credential self_{ca_.certificate(), ca_.key()};
  Credential leaf_ = make_leaf(ca_);
};

TEST_F(SmimeDiagnosis, FormThatWeWrite_IsKnownAndBelieved) {
  const auto file = signed_by(self_);
  const auto form = examine(file);
  EXPECT_EQ(form.wrapping, DocumentWrapping::multipart);
  EXPECT_TRUE(form.has_text_header);
  EXPECT_EQ(form.embedded, std::vector<std::string>{"CN=Permissions CA"});
  EXPECT_EQ(form.signer_issuer, "CN=Permissions CA");
  EXPECT_EQ(form.signer_serial, ca_.certificate().serial());
  ASSERT_EQ(form.signer_certificates.size(), 1U);
  EXPECT_TRUE(std::ranges::equal(form.signer_certificates[0], ca_.certificate().der()));
  EXPECT_EQ(as_text(form.unverified_text), kDocument);
  EXPECT_TRUE(verified(file));
}

TEST_F(SmimeDiagnosis, TheLineOfTheText_IsTheFiles) {
  const auto line_of = [](std::string_view file) {
    return 1 + static_cast<int>(std::ranges::count(file.substr(0, file.find("<dds")), '\n'));
  };
  const auto file = signed_by(self_);
  const OddDocument plain(self_, PKCS7_DETACHED);
  for (const auto& one : {std::string(file), std::string(plain.smime())}) {
    EXPECT_EQ(examine(one).first_line, line_of(one)) << one;
    EXPECT_GT(examine(one).first_line, 4);
  }
  // If the lines of the file cannot be read, lines are counted in the text itself.
  EXPECT_EQ(examine(OddDocument(self_, PKCS7_TEXT).smime()).first_line, 1);
  EXPECT_EQ(examine(kDocument).first_line, 1);
}

TEST_F(SmimeDiagnosis, EveryOtherForm_IsToldApart) {
  const OddDocument plain(self_, PKCS7_DETACHED);
  EXPECT_EQ(examine(plain.smime()).wrapping, DocumentWrapping::multipart);
  EXPECT_FALSE(examine(plain.smime()).has_text_header);
  EXPECT_EQ(as_text(examine(plain.smime()).unverified_text), kDocument);
  EXPECT_CODE(verified(plain.smime()), smime_signature_invalid);

  const OddDocument opaque(self_, PKCS7_TEXT);
  const auto form = examine(opaque.smime());
  EXPECT_EQ(form.wrapping, DocumentWrapping::opaque);
  EXPECT_TRUE(form.has_text_header);
  EXPECT_EQ(as_text(form.unverified_text), kDocument);
  EXPECT_TRUE(verified(opaque.smime()));

  EXPECT_EQ(examine(opaque.pem()).wrapping, DocumentWrapping::pem);
  EXPECT_EQ(as_text(examine(opaque.pem()).unverified_text), kDocument);
  EXPECT_EQ(examine(opaque.der()).wrapping, DocumentWrapping::der);
  EXPECT_CODE(verified(opaque.der()), smime_malformed);

  EXPECT_EQ(examine(kDocument).wrapping, DocumentWrapping::none);
  EXPECT_EQ(as_text(examine(kDocument).unverified_text), kDocument);
  EXPECT_CODE(verified(kDocument), smime_malformed);
  EXPECT_EQ(examine("nothing at all").wrapping, DocumentWrapping::unknown);
  EXPECT_EQ(examine("").wrapping, DocumentWrapping::unknown);
}

TEST_F(SmimeDiagnosis, PartsThatOnlyOpensslFinds_AreAmbiguous) {
  const auto file = signed_by(self_);
  EXPECT_FALSE(examine(file).ambiguous);
  EXPECT_FALSE(examine(OddDocument(self_, PKCS7_DETACHED).smime()).ambiguous);
  const auto form =
      examine(replaced(file, "This is an", "X: " + std::string(1020, 'x') + "\nThis is an"));
  ASSERT_TRUE(form.ambiguous);
  EXPECT_EQ(form.ambiguous->code(), Code::smime_surrounding_text);
}

// `openssl cms -sign -keyid` makes such a signature. PKCS#7 cannot express this signer.
TEST_F(SmimeDiagnosis, ASignerNamedByItsKey_IsReadAsThePluginsDo) {
  const auto ca = make_ca();
  constexpr unsigned kFlags = CMS_DETACHED | CMS_TEXT | CMS_USE_KEYID | CMS_STREAM;
  const BioPtr data = bio_over(as_bytes(kDocument)), again = bio_over(as_bytes(kDocument));
  const CmsPtr cms(CMS_sign(impl_of(ca.certificate()).x509.get(), impl_of(ca.key()).pkey.get(),
                            nullptr, data.get(), kFlags));
  const BioPtr out(BIO_new(BIO_s_mem()));
  ASSERT_EQ(SMIME_write_CMS(out.get(), cms.get(), again.get(), kFlags), 1);
  const auto form = examine(as_text(bio_octets(out)));
  EXPECT_EQ(form.wrapping, DocumentWrapping::multipart);
  EXPECT_EQ(as_text(form.unverified_text), kDocument);
  EXPECT_EQ(form.embedded, std::vector{ca.certificate().subject()});
  EXPECT_EQ(form.signer_certificates, std::vector<Bytes>{to_bytes(ca.certificate().der())});
  EXPECT_EQ(form.signer_key_id.size(), 40u);
  EXPECT_EQ(signer_words(form), "the key " + form.signer_key_id + " (subject key identifier)");
  EXPECT_FALSE(form.ambiguous);
}

TEST_F(SmimeDiagnosis, DocumentWithoutCertificates_EmbedsNone) {
  const OddDocument bare(self_, PKCS7_DETACHED | PKCS7_TEXT | PKCS7_NOCERTS);
  EXPECT_TRUE(examine(bare.smime()).embedded.empty());
  EXPECT_TRUE(examine(bare.smime()).signer_certificates.empty());
  EXPECT_EQ(examine(bare.smime()).signer_issuer, "CN=Permissions CA");
  EXPECT_CODE(verified(bare.smime()), smime_signature_invalid);
}

TEST_F(SmimeDiagnosis, StockProducts_BelieveALeafAndRefuseStrangersChangesAndOldCas) {
  EXPECT_TRUE(verified(signed_by(leaf_)));  // CVE-2023-24010 and CVE-2023-24011
  const auto stranger = make_ca("CN=Stranger");
  EXPECT_CODE(verified(signed_by({stranger.certificate(), stranger.key()})),
              smime_signature_invalid);
  EXPECT_CODE(verified(replaced(signed_by(self_), "</dds>", "<dds/>")), smime_signature_invalid);
  EXPECT_CODE(verified(signed_by(self_), kNow + 400 * 24h), smime_signature_invalid);
}

TEST_F(SmimeDiagnosis, CutOffAndFlippedFiles_DoNoHarm) {
  const auto file = signed_by(self_);
  for (std::size_t size = 0; size < file.size(); ++size) examine(file.substr(0, size));
  const auto der = OddDocument(self_, PKCS7_TEXT).der();
  for (std::size_t at = 0; at < der.size(); ++at) {
    auto changed = der;
    changed[at] = static_cast<char>(changed[at] ^ 0x20);
    examine(changed);
    examine(changed.substr(0, at));
  }
  EXPECT_EQ(examine(std::string(17 * 1024 * 1024, '<')).wrapping, DocumentWrapping::unknown);
  EXPECT_CODE(verified(std::string(17 * 1024 * 1024, '<')), smime_too_large);
}

TEST(DocumentWrapping, EachWrapping_HasWords) {
  EXPECT_EQ(to_string(DocumentWrapping::multipart), "multipart/signed");
  EXPECT_EQ(to_string(DocumentWrapping::none), "unsigned XML");
}

}  // namespace
}  // namespace ddssec::pki
