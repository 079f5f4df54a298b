#include "plugins/authentication/identity_token.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(IdentityToken, WrittenToken_HasCyclonesWords) {
  const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  const auto token =
      write_identity_token(identity.certificate, test_ca().certificate(), spi::kStandardCiphers);
  EXPECT_EQ(token.class_id, "DDS:Auth:PKI-DH:1.0");
  const PropertyList expected = {{"dds.cert.sn", "/O=Example/CN=alice"},
                                 {"dds.cert.algo", "EC-prime256v1"},
                                 {"dds.ca.sn", "/O=Example/CN=Identity CA"},
                                 {"dds.ca.algo", "EC-prime256v1"}};
  EXPECT_EQ(token.properties, expected);
  EXPECT_EQ(read_identity_token(token)->subject, "/O=Example/CN=alice");
}

TEST(IdentityToken, NonStandardCiphers_AreAnnounced) {
  const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  const auto& ca = test_ca().certificate();
  const auto token = write_identity_token(identity.certificate, ca, spi::kAllCiphers);
  ASSERT_EQ(token.properties.size(), 5u);
  EXPECT_EQ(token.properties[4],
            (spi::Property{"org.ddssec.symmetric_ciphers", "org.ddssec.ChaCha20-Poly1305"}));
  EXPECT_EQ(announced_ciphers(token), spi::kAllCiphers);
  EXPECT_EQ(announced_ciphers({}), spi::kStandardCiphers);
  auto other = token;
  other.properties[4].value = "com.example.Cipher";
  EXPECT_EQ(announced_ciphers(other), spi::kStandardCiphers);
}

TEST(IdentityToken, AbsentProperties_AreAllowedAnAbsentClassIsNot) {
  EXPECT_TRUE(read_identity_token({"DDS:Auth:PKI-DH:1.2"}));
  EXPECT_CODE(read_identity_token({"DDS:Auth:Other:1.0"}), token_class_wrong);
  EXPECT_CODE(read_identity_token({"DDS:Auth:PKI-DH:1.0+Req"}), token_class_wrong);
  EXPECT_CODE(read_identity_token({""}), token_class_wrong);
}

}  // namespace
}  // namespace ddssec::authentication
