#include "pki/certificate.hpp"

#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

const std::string kCyclone = "cyclonedds/validate_local_identity/";
const std::string kPyca = "pyca-cryptography-vectors/x509/";

TEST(Certificate, Fields_AreWhatItHolds) {
  const auto ca = make_ca("CN=Root+OU=x,O=Example\\, Inc,C=NL");
  const auto leaf = make_leaf(ca, "CN=talker,O=Example");
  const auto again = Certificate::from_pem(as_bytes(leaf.certificate.pem()));
  ASSERT_TRUE(again) << again.error().to_sentence();
  EXPECT_EQ(*again, leaf.certificate);
  EXPECT_EQ(again->pem(), leaf.certificate.pem());
  EXPECT_TRUE(again->pem().ends_with("-----END CERTIFICATE-----\n"));
  EXPECT_EQ(again->fingerprint(), sha256(again->der()));
  EXPECT_EQ(again->not_before(), kYear.not_before);
  EXPECT_EQ(again->not_after(), kYear.not_after);
  EXPECT_EQ(to_string(again->key_algorithm()), "EC-prime256v1");
  EXPECT_EQ(again->serial().size(), 32u);
  EXPECT_NE(*again, ca.certificate());
  EXPECT_NE(ca.certificate().subject().find("O=Example\\, Inc"), std::string::npos);
  EXPECT_EQ(again->issuer(), ca.certificate().subject());
}

TEST(Certificate, SecondReaderOfOneThatIsHeld_SharesIt) {
  const auto ca = make_ca("CN=Root");
  const auto pem = make_leaf(ca, "CN=talker").certificate.pem();
  {
    const auto held = Certificate::from_pem(as_bytes(pem)).value();
    const auto again = Certificate::from_der(held.der()).value();
    EXPECT_EQ(&impl_of(held), &impl_of(again));
    EXPECT_NE(&impl_of(held), &impl_of(ca.certificate()));
  }
  // No object held the certificate any longer, so it was read again. However many certificates
  // come, each is right.
  for (int i = 0; i < 200; ++i) {
    const auto leaf = make_leaf(ca, "CN=talker " + std::to_string(i));
    const auto read = Certificate::from_pem(as_bytes(leaf.certificate.pem())).value();
    EXPECT_EQ(read.subject(), "CN=talker " + std::to_string(i));
  }
  EXPECT_EQ(Certificate::from_pem(as_bytes(pem))->subject(), "CN=talker");
}

TEST(Certificate, SubjectDigest_IsOverTheDerName) {
  // CN=abc differs between PrintableString and UTF8String, so the test takes the DER as the library
  // encodes it.
  const auto ca = make_ca("CN=abc");
  const auto* name = X509_get_subject_name(impl_of(ca.certificate()).x509.get());
  unsigned char digest[32];
  ASSERT_EQ(X509_NAME_digest(name, EVP_sha256(), digest, nullptr), 1);
  EXPECT_EQ(to_hex(ca.certificate().subject_digest()), to_hex(digest));
}

TEST(Certificate, AnEcLeafUnderAnRsaCa_KnowsBoth) {
  const auto ca = make_ca("CN=Root", {KeyKind::rsa, 2048});
  const auto leaf = make_leaf(ca);
  EXPECT_EQ(leaf.certificate.key_algorithm().kind, KeyKind::ec_p256);
  EXPECT_EQ(to_string(ca.certificate().key_algorithm()), "RSA-2048");
}

TEST(Certificate, TextAroundTheBlockAndOneNul_AreTolerated) {
  const auto pem = make_ca().certificate().pem();
  EXPECT_TRUE(Certificate::from_pem(as_bytes("Certificate:\n  Data:\n" + pem + "text")));
  EXPECT_TRUE(Certificate::from_pem(as_bytes(pem + std::string(1, '\0'))));
  const auto two = make_ca("CN=Other").certificate().pem();
  EXPECT_EQ(Certificate::from_pem(as_bytes(pem + two))->pem(), pem);
  std::string crlf;
  for (char c : pem) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_EQ(Certificate::from_pem(as_bytes(crlf))->pem(), pem);
}

TEST(Certificate, DamagedDate_IsShown) {
  const auto der = to_bytes(make_ca().certificate().der());
  std::string octets(as_text(der));
  const auto date = octets.find("Z\x17\x0d");  // the end of notBefore, and the head of notAfter
  ASSERT_NE(date, octets.npos);
  for (const auto& [at, field] : {std::pair(date - 8, "notBefore"), {date + 7, "notAfter"}}) {
    auto damaged = octets;
    damaged[at] = '\x1b';
    const auto read = Certificate::from_der(as_bytes(damaged));
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code(), Code::certificate_malformed);
    EXPECT_EQ(read.error().details().field, field);
    EXPECT_EQ(read.error().details().found.find('\x1b'), std::string::npos);
    EXPECT_EQ(read.error().details().found.size(), 15u);  // 13 characters and quotes
  }
}

TEST(Certificate, EveryTruncation_IsRefused) {
  const auto certificate = make_ca().certificate();
  const auto pem = as_bytes(certificate.pem());
  for (std::size_t size = 0; size + 2 < pem.size(); ++size)
    EXPECT_CODE(Certificate::from_pem(pem.first(size)), certificate_malformed);
  for (std::size_t size = 0; size < certificate.der().size(); ++size)
    EXPECT_CODE(Certificate::from_der(certificate.der().first(size)), certificate_malformed);
}

TEST(Certificate, AFlippedBit_NeverGivesAnEqualCertificate) {
  const auto certificate = make_ca().certificate();
  auto der = to_bytes(certificate.der());
  for (std::size_t at = 0; at < der.size(); ++at) {
    der[at] ^= 1;
    const auto changed = Certificate::from_der(der);
    EXPECT_FALSE(changed && *changed == certificate) << at;
    der[at] ^= 1;
  }
}

TEST(Certificate, OctetsBehindIt_AreRefused) {
  auto der = to_bytes(make_ca().certificate().der());
  der.push_back(0);
  EXPECT_CODE(Certificate::from_der(der), certificate_malformed);
  EXPECT_CODE(Certificate::from_pem(as_bytes("-----BEGIN CERTIFICATE-----\n" + base64(der) +
                                             "\n-----END CERTIFICATE-----\n")),
              certificate_malformed);
}

// Found by fuzzing: unused bits of the signature are not written again.
TEST(Certificate, OtherOctetsThanTheDistinguishedOnes_AreRefused) {
  auto der = to_bytes(make_leaf(make_ca(), "CN=talker").certificate.der());
  const Bytes begin = {0x00, 0x30};  // no unused bits, and the two integers of the signature
  const auto bits_left = std::find_end(der.begin(), der.end(), begin.begin(), begin.end());
  ASSERT_EQ(bits_left[-2], 0x03);
  ASSERT_EQ(bits_left[-1], der.end() - bits_left);
  *bits_left = 1;
  der.back() |= 1;
  EXPECT_CODE(Certificate::from_der(der), certificate_malformed);
}

// T34 (docs/attacks.md): a certificate of a megabyte.
TEST(Certificate, Sizes_AreBounded) {
  const auto pem = make_ca().certificate().pem();
  EXPECT_CODE(Certificate::from_pem(as_bytes(std::string(1000000, 'A') + pem)),
              certificate_too_large);
  EXPECT_CODE(Certificate::from_der(Bytes(1000000)), certificate_too_large);
  EXPECT_CODE(Certificate::bundle_from_pem(Bytes(kMaxBundleOctets + 1)), certificate_too_large);
  std::string many;
  for (std::size_t i = 0; i <= kMaxCertificatesInBundle; ++i) many += pem;
  EXPECT_CODE(Certificate::bundle_from_pem(as_bytes(many)), certificate_too_large);
}

std::string attributes(int count) {
  std::string text = "CN=a";
  for (int i = 1; i < count; ++i) text += ",OU=" + std::to_string(i);
  return text;
}

// Makes a certificate with names that our own issuing refuses, with OpenSSL directly.
Result<Certificate> with_name(const std::vector<std::pair<std::string, std::string>>& entries) {
  const auto ca = make_ca();
  const X509Ptr x509(X509_dup(impl_of(ca.certificate()).x509.get()));
  const NamePtr name(X509_NAME_new());
  for (const auto& [type, value] : entries)
    X509_NAME_add_entry_by_txt(name.get(), type.c_str(), V_ASN1_UTF8STRING, as_bytes(value).data(),
                               static_cast<int>(value.size()), -1, 0);
  X509_set_subject_name(x509.get(), name.get());
  X509_sign(x509.get(), impl_of(ca.key()).pkey.get(), EVP_sha256());
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  return Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
}

TEST(Certificate, Names_AreBoundedAndHoldNoNul) {
  using namespace std::string_literals;
  EXPECT_EQ(make_ca(attributes(kMaxNameAttributes)).certificate().subject(),
            attributes(kMaxNameAttributes));
  const std::vector<std::pair<std::string, std::string>> thousand(1000, {"OU", "x"});
  EXPECT_CODE(with_name(thousand), name_not_allowed);
  EXPECT_CODE(with_name({{"CN", "admin\0.example.org"s}}), name_not_allowed);
  const auto good = with_name({{"CN", "a"}, {"CN", "a"}});
  ASSERT_TRUE(good) << good.error().to_sentence();
  EXPECT_EQ(good->subject(), "CN=a,CN=a");
}

// Certificates are read without the decoders for this type of key.
TEST(Certificate, AKeyOfAnotherType_IsNamed) {
  const auto ca = make_ca();
  const X509Ptr x509(X509_dup(impl_of(ca.certificate()).x509.get()));
  const PkeyPtr key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  ASSERT_EQ(X509_set_pubkey(x509.get(), key.get()), 1);
  ASSERT_GT(X509_sign(x509.get(), impl_of(ca.key()).pkey.get(), EVP_sha256()), 0);
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  const auto refused = Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
  EXPECT_CODE(refused, key_not_allowed);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().details().found, "a key of ED25519") << refused.error().to_sentence();
}

TEST(Certificate, KeysOutsideTheRules_AreNamed) {
  const auto check = [](const std::string& file, const char* found) {
    const auto certificate = Certificate::from_pem(data_file(file));
    EXPECT_CODE(certificate, key_not_allowed);
    if (certificate) return;
    EXPECT_NE(certificate.error().details().found.find(found), std::string::npos)
        << certificate.error().to_sentence();
  };
  check(kCyclone + "identity_certificate_1024key", "RSA of 1024 bits");
  check(kCyclone + "ec_identity_certificate_unsupported", "EC prime192v2 of 192 bits");
  check(kPyca + "ec_no_named_curve.pem", "EC of 256 bits");
}

TEST(Certificate, CyclonesIdentities_Parse) {
  for (const char* name :
       {"identity_certificate", "ec_identity_certificate", "identity_ca", "ec_identity_ca"}) {
    const auto certificate = Certificate::from_pem(data_file(kCyclone + name));
    EXPECT_TRUE(certificate) << name << certificate.error().to_sentence();
  }
  EXPECT_CODE(Certificate::from_pem(data_file(kCyclone + "alice.pem")), certificate_malformed);
  EXPECT_CODE(Certificate::from_pem(data_file(kCyclone + "private_key")), certificate_malformed);
}

TEST(Certificate, OddOnes_GetAClearVerdict) {
  const auto verdict = [](const char* name) {
    const auto octets = data_file(kPyca + name);
    const bool der = std::string_view(name).ends_with(".der");
    const auto out = der ? Certificate::from_der(octets) : Certificate::from_pem(octets);
    return out ? std::string("ok") : std::string(info(out.error().code()).name);
  };
  EXPECT_EQ(verdict("invalid_utf8_common_name.pem"), "certificate_malformed");
  EXPECT_EQ(verdict("two_basic_constraints.pem"), "certificate_malformed");
  EXPECT_EQ(verdict("negative_serial.pem"), "ok");
  EXPECT_EQ(verdict("utf8_common_name.pem"), "ok");
  EXPECT_EQ(verdict("unique_identifier.pem"), "name_not_allowed");
  EXPECT_EQ(verdict("long-form-name-attribute.pem"), "certificate_malformed");
  EXPECT_EQ(verdict("v1_cert.pem"), "key_not_allowed");
  EXPECT_EQ(verdict("rsa_pss_cert.pem"), "key_not_allowed");
  EXPECT_EQ(verdict("scottishpower-bitstring-dn.pem"), "name_not_allowed");
}

TEST(Certificate, DerFile_IsNamedWithTheCommandThatConverts) {
  const auto ca = make_ca();
  const auto one = Certificate::from_pem(ca.certificate().der());
  const auto bundle = Certificate::bundle_from_pem(ca.certificate().der());
  ASSERT_FALSE(one || bundle);
  for (const auto& error : {one.error(), bundle.error()}) {
    EXPECT_EQ(error.code(), Code::certificate_malformed);
    EXPECT_EQ(error.details().found, "DER");
    EXPECT_EQ(error.hint(), "write it as PEM: openssl x509 -inform DER -in FILE -out FILE.pem");
  }
  const auto text = Certificate::from_pem(as_bytes("0 text"));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().details().note, "there is no PEM block CERTIFICATE");
}

TEST(Bundle, OtherBlocks_ArePassedOverAndEveryCertificateIsHeld) {
  const auto a = make_ca("CN=a");
  const auto b = make_ca("CN=b");
  const auto crl = a.make_crl({{}, kNow, kNow + 24h});
  ASSERT_TRUE(crl);
  const auto bundle = Certificate::bundle_from_pem(
      as_bytes(a.certificate().pem() + crl->pem() + b.certificate().pem()));
  ASSERT_TRUE(bundle) << bundle.error().to_sentence();
  EXPECT_EQ(*bundle, (std::vector{a.certificate(), b.certificate()}));
  EXPECT_CODE(Certificate::bundle_from_pem(as_bytes(crl->pem())), certificate_malformed);
  EXPECT_CODE(Certificate::bundle_from_pem({}), certificate_malformed);
  EXPECT_CODE(Certificate::bundle_from_pem(
                  as_bytes(a.certificate().pem() + "-----BEGIN CERTIFICATE-----\nMIIB!\n")),
              certificate_malformed);
}

}  // namespace
}  // namespace ddssec::pki
