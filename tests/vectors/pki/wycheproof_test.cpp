// Google's Wycheproof vectors for the operations of a handshake.
#include <nlohmann/json.hpp>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki/signature.hpp"
#include "tests/support/known_key.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

nlohmann::json vectors(const std::string& name) {
  const auto file = data_file("wycheproof/" + name + ".json");
  return nlohmann::json::parse(file.begin(), file.end());
}

Bytes octets(const nlohmann::json& hex) { return *from_hex(hex.get<std::string>()); }

// Makes a certificate with another owner's public key, so that our own functions accept the key.
Result<Certificate> certificate_for(const PkeyPtr& key) {
  static const auto ca = make_ca();
  const X509Ptr x509(X509_new());
  ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
  X509_set_issuer_name(x509.get(), X509_get_subject_name(impl_of(ca.certificate()).x509.get()));
  X509_time_adj_ex(X509_getm_notBefore(x509.get()), 0, 0, nullptr);
  X509_time_adj_ex(X509_getm_notAfter(x509.get()), 1, 0, nullptr);
  X509_set_pubkey(x509.get(), key.get());
  X509_sign(x509.get(), impl_of(ca.key()).pkey.get(), EVP_sha256());
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  return Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
}

PkeyPtr public_key(const nlohmann::json& group) {
  const bool ec = group.contains("publicKeyDer");
  const auto der = octets(ec ? group["publicKeyDer"] : group["publicKeyAsn"]);
  const auto* position = der.data();
  const auto size = static_cast<long>(der.size());
  return PkeyPtr(ec ? d2i_PUBKEY(nullptr, &position, size)
                    : d2i_PublicKey(EVP_PKEY_RSA, nullptr, &position, size));
}

class WycheproofSignatures : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Wycheproof, WycheproofSignatures,
                         testing::Values("ecdsa_secp256r1_sha256_test",
                                         "ecdsa_secp384r1_sha384_test",
                                         "rsa_pss_2048_sha256_mgf1_32_test"));

TEST_P(WycheproofSignatures, ValidOnes_PassAndInvalidOnesDoNot) {
  int valid = 0, invalid = 0;
  const auto file = vectors(GetParam());
  for (const auto& group : file["testGroups"]) {
    const auto certificate = certificate_for(public_key(group));
    ASSERT_TRUE(certificate) << certificate.error().to_sentence();
    for (const auto& test : group["tests"]) {
      const bool ok = verify(*certificate, octets(test["msg"]), octets(test["sig"])).has_value();
      if (test["result"] == "acceptable") continue;
      // Any salt length is accepted (DDS-Security 1.2 wants it detected), but the vectors demand
      // 32.
      const auto flags = test["flags"].dump() + test["comment"].dump();
      if (test["result"] == "invalid" && flags.find("s_len") != flags.npos) continue;
      EXPECT_EQ(ok, test["result"] == "valid") << test.dump();
      (ok ? valid : invalid) += 1;
    }
  }
  EXPECT_GE(valid, 10);
  EXPECT_GE(invalid, 10);
}

class Points : public testing::TestWithParam<std::pair<const char*, KeyAgreementKind>> {};
INSTANTIATE_TEST_SUITE_P(
    Wycheproof, Points,
    testing::Values(std::pair("ecdh_secp256r1_ecpoint_test", KeyAgreementKind::ecdh_p256),
                    std::pair("ecdh_secp384r1_ecpoint_test", KeyAgreementKind::ecdh_p384)));

TEST_P(Points, ValidOnes_GiveTheSharedSecretAndInvalidOnesAreRefused) {
  const auto [name, kind] = GetParam();
  int valid = 0, invalid = 0;
  const auto file = vectors(name);
  for (const auto& group : file["testGroups"]) {
    for (const auto& test : group["tests"]) {
      const auto key = KnownKey::from_private(kind, octets(test["private"]));
      ASSERT_TRUE(key) << test.dump();
      const auto secret = key->derive(octets(test["public"]));
      // "acceptable" means compressed points here. DDS-Security demands uncompressed ones.
      if (test["result"] != "valid") {
        EXPECT_FALSE(secret) << test.dump();
        ++invalid;
        continue;
      }
      ASSERT_TRUE(secret) << test.dump();
      EXPECT_EQ(*secret, *AgreedSecret::copy_of(sha256(octets(test["shared"])))) << test.dump();
      ++valid;
    }
  }
  EXPECT_GE(valid, 100);
  EXPECT_GE(invalid, 3);
}

}  // namespace
}  // namespace ddssec::pki
