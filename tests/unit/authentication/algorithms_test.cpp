#include "plugins/authentication/algorithms.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(Algorithms, OneTrailingNul_IsStrippedForComparison) {
  EXPECT_EQ(algorithm_text(bytes("ECDSA-SHA256")), "ECDSA-SHA256");
  EXPECT_EQ(algorithm_text(bytes(std::string_view("A\0", 2))), "A");
  EXPECT_EQ(algorithm_text(bytes(std::string_view("A\0\0", 3))), std::string_view("A\0", 2));
  EXPECT_EQ(algorithm_text({}), "");
}

TEST(Algorithms, EachKey_IsAnnouncedInWordsOfStockPeers) {
  EXPECT_EQ(signature_algorithm_name({KeyKind::rsa, 2048}), "RSASSA-PSS-SHA256");
  EXPECT_EQ(signature_algorithm_name({KeyKind::ec_p256, 256}), "ECDSA-SHA256");
  EXPECT_EQ(signature_algorithm_name({KeyKind::ec_p384, 384}), "ECDSA+P384+SHA384");
  EXPECT_EQ(key_agreement_name(pki::KeyAgreementKind::ecdh_p256), "ECDH+prime256v1-CEUM");
  EXPECT_EQ(key_agreement_name(pki::KeyAgreementKind::dh_modp_2048_256), "DH+MODP-2048-256");
}

TEST(Algorithms, UnknownNames_AreNothing) {
  for (const auto name : {"", "ecdsa-sha256", "ECDSA-SHA256 ", "RSASSA-PKCS1-V1_5+2048+SHA256"})
    EXPECT_FALSE(is_signature_algorithm(name)) << name;
  for (const auto name : {"", "AUTO", "DH+MODP-1024", "ECDH+prime256v1-CEUMx"})
    EXPECT_FALSE(key_agreement_kind_from(name)) << name;
}

}  // namespace
}  // namespace ddssec::authentication
