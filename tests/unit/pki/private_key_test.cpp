#include "pki/private_key.hpp"

#include <gmock/gmock.h>

#include "pki/signature.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

const std::string kCyclone = "cyclonedds/validate_local_identity/";

Passphrase passphrase(std::string_view text) { return *Passphrase::copy_of(as_bytes(text)); }

TEST(PrivateKey, PlainAndEncryptedForms_AreRead) {
  const auto right = passphrase("CHAM569");
  EXPECT_TRUE(PrivateKey::from_pem(data_file(kCyclone + "private_key")));
  EXPECT_TRUE(PrivateKey::from_pem(data_file(kCyclone + "ec_private_key")));
  const auto key = PrivateKey::from_pem(data_file(kCyclone + "private_key_w_password"), &right);
  EXPECT_TRUE(key) << key.error().to_sentence();
}

TEST(PrivateKey, WrongAndMissingPassphrase_Differ) {
  const auto wrong = passphrase("wrong");
  for (const char* name : {"private_key_w_password", "ec_private_key_w_password"}) {
    const auto pem = data_file(kCyclone + name);
    EXPECT_CODE(PrivateKey::from_pem(pem), passphrase_missing);
    EXPECT_CODE(PrivateKey::from_pem(pem, &wrong), passphrase_wrong);
    for (const auto& refused : {PrivateKey::from_pem(pem), PrivateKey::from_pem(pem, &wrong)})
      EXPECT_EQ(refused.error().details().note, "") << "OpenSSL's reason does not help";
  }
}

class OwnKeys : public testing::TestWithParam<KeyKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, OwnKeys,
                         testing::Values(KeyKind::rsa, KeyKind::ec_p256, KeyKind::ec_p384));

TEST_P(OwnKeys, WrittenKey_ReadsBack) {
  const auto key = *PrivateKey::generate(GetParam());
  const auto right = passphrase("correct horse");
  const auto wrong = passphrase("correct mule");
  const auto plain = key.to_pem();
  const auto closed = key.to_pem(&right);
  ASSERT_TRUE(plain && closed);
  EXPECT_EQ(PrivateKey::from_pem(*plain)->algorithm(), key.algorithm());
  EXPECT_EQ(PrivateKey::from_pem(*closed, &right)->algorithm(), key.algorithm());
  EXPECT_CODE(PrivateKey::from_pem(*closed), passphrase_missing);
  EXPECT_CODE(PrivateKey::from_pem(*closed, &wrong), passphrase_wrong);
  EXPECT_TRUE(closed->expose([](BytesView pem) {
    return as_text(pem).starts_with("-----BEGIN ENCRYPTED PRIVATE KEY-----");
  }));
}

TEST(PrivateKey, RsaOfARefusedSize_IsNotMade) {
  for (const int bits : {-1, 0, 2047, 16385}) {
    const auto key = PrivateKey::generate(KeyKind::rsa, bits);
    EXPECT_CODE(key, key_not_allowed);
    EXPECT_EQ(key.error().details().found, "RSA of " + std::to_string(bits) + " bits");
  }
}

TEST(PrivateKey, DerFile_IsNamedWithTheCommandThatConverts) {
  // These are the first octets of a PKCS #8 key of P-256, and of a SEC 1 key of 119 octets.
  Bytes pkcs8(138), sec1(121);
  pkcs8[0] = sec1[0] = 0x30;
  pkcs8[1] = 0x81;
  pkcs8[2] = 135;
  sec1[1] = 119;
  for (const auto& der : {pkcs8, sec1}) {
    const auto key = PrivateKey::from_pem(der);
    EXPECT_CODE(key, private_key_malformed);
    EXPECT_EQ(key.error().details().found, "DER");
    EXPECT_THAT(key.error().hint(), ::testing::HasSubstr("openssl pkey -inform DER"));
  }
  const auto text = PrivateKey::from_pem(as_bytes("0 is no length"));
  EXPECT_CODE(text, private_key_malformed);
  EXPECT_EQ(text.error().details().found, "");
}

TEST(PrivateKey, OtherThings_AreRefused) {
  EXPECT_CODE(PrivateKey::from_pem(BytesView()), private_key_malformed);
  EXPECT_CODE(PrivateKey::from_pem(as_bytes("junk")), private_key_malformed);
  EXPECT_CODE(PrivateKey::from_pem(as_bytes(make_ca().certificate().pem())), private_key_malformed);
  EXPECT_CODE(PrivateKey::from_pem(Bytes(20000)), private_key_malformed);
  EXPECT_CODE(PrivateKey::from_pem(data_file(kCyclone + "invalid_private_key")),
              private_key_malformed);
  EXPECT_CODE(PrivateKey::from_pem(data_file(kCyclone + "private_key_1024")), key_not_allowed);
  EXPECT_CODE(PrivateKey::from_pem(data_file(kCyclone + "ec_private_key_unsupported")),
              key_not_allowed);
}

TEST(PrivateKey, EveryTruncation_IsRefused) {
  const auto pem = *PrivateKey::generate(KeyKind::ec_p256)->to_pem();
  pem.expose([](BytesView octets) {
    for (std::size_t size = 0; size + 2 < octets.size(); ++size)
      EXPECT_CODE(PrivateKey::from_pem(octets.first(size)), private_key_malformed);
  });
}

TEST(PrivateKey, AnothersCertificate_DoesNotMatch) {
  const auto key = *PrivateKey::from_pem(data_file(kCyclone + "private_key"));
  const auto other = *PrivateKey::from_pem(data_file(kCyclone + "private_key_not_matching"));
  const auto ec = *PrivateKey::from_pem(data_file(kCyclone + "ec_private_key"));
  const auto certificate = *Certificate::from_pem(data_file(kCyclone + "identity_certificate"));
  const auto ec_certificate =
      *Certificate::from_pem(data_file(kCyclone + "ec_identity_certificate"));
  EXPECT_TRUE(key.check_fits(certificate)) << key.check_fits(certificate).error().to_sentence();
  EXPECT_TRUE(ec.check_fits(ec_certificate));
  EXPECT_CODE(other.check_fits(certificate), key_mismatch);
  EXPECT_CODE(ec.check_fits(certificate), key_mismatch);
}

TEST(Signature, FlippedBitsTruncationAndLength_AreRefused) {
  const auto leaf = make_leaf(make_ca());
  const auto message = bytes("hash_c2 challenge2");
  auto signature = *sign(leaf.key, message);
  ASSERT_TRUE(verify(leaf.certificate, message, signature));
  EXPECT_EQ(verify(leaf.certificate, message, signature)->signer(), leaf.certificate);
  for (std::size_t at = 0; at < signature.size(); ++at) {
    EXPECT_CODE(verify(leaf.certificate, message, BytesView(signature).first(at)),
                signature_invalid);
    signature[at] ^= 1;
    EXPECT_CODE(verify(leaf.certificate, message, signature), signature_invalid);
    signature[at] ^= 1;
  }
  signature.push_back(0);
  EXPECT_CODE(verify(leaf.certificate, message, signature), signature_invalid);
  EXPECT_CODE(verify(leaf.certificate, message, Bytes(kMaxSignatureOctets + 1)), signature_invalid);
}

}  // namespace
}  // namespace ddssec::pki
