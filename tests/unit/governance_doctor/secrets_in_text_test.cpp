// Passwords and keys in each kind of configuration.
#include "governance/doctor/secrets_in_text.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

TEST(SecretInText, PasswordAndPrivateKey_AreFoundInEachKindOfFile) {
  for (const auto* text : {"<Authentication><Password>secret</Password></Authentication>",
                           "<password>\n  secret\n</password>", "dds.sec.auth.password = secret\n",
                           "a = b\ndds.sec.auth.password=data:,secret",
                           "<property><name>dds.sec.auth.builtin.PKI-DH.password</name>\n "
                           "<value>secret</value></property>",
                           "<PrivateKey>data:,-----BEGIN PRIVATE KEY-----\nMIGH",
                           "<PrivateKey>data:,-----BEGIN ENCRYPTED PRIVATE KEY-----",
                           "<PrivateKey>pkcs11:object=talker?pin-value=1234</PrivateKey>",
                           "dds.sec.crypto.rtps_psk_secret_passphrase = data:,7:secret",
                           "dds.sec.crypto.rtps_psk_secret_passphrase_extra = 7:secret"})
    EXPECT_TRUE(secrets_in(text).are_there) << text;
}

TEST(SecretInText, EmptyPasswordOrTheNameOfAFile_IsNone) {
  for (const auto* text :
       {"", "<Password></Password>",
        "<Password>\n</Password><PrivateKey>file:/key.pem</PrivateKey>",
        "dds.sec.auth.password = file:/run/secrets/password\n", "dds.sec.auth.password =",
        "<property><name>dds.sec.auth.builtin.PKI-DH.password</name><value></value></property>",
        "<PrivateKey>file:/password.pem</PrivateKey>", "-----BEGIN CERTIFICATE-----"})
    EXPECT_FALSE(secrets_in(text).are_there) << text;
}

TEST(SecretInText, FilesThatAreNamedAsSecrets_AreTold) {
  const auto secrets = secrets_in(
      "dds.sec.auth.password = file:/Run/password \n"
      "dds.sec.crypto.rtps_psk_secret_passphrase=file:///run/7.psk\n"
      "<Password>file:/run/other</Password><PrivateKey>file:/run/key.pem</PrivateKey>"
      "<Password>file:secrets/third</Password>");
  EXPECT_FALSE(secrets.are_there);
  EXPECT_EQ(secrets.files,
            (std::vector<std::filesystem::path>{"/Run/password", "/run/other", "secrets/third"}));
  EXPECT_EQ(secrets.passphrase_files, (std::vector<std::filesystem::path>{"/run/7.psk"}));
}

TEST(SecretInText, FilesOfFurtherPassphrases_AreToldOnce) {
  const auto secrets =
      secrets_in("dds.sec.crypto.rtps_psk_secret_passphrase_extra = file:/run/old.psk\n");
  EXPECT_EQ(secrets.passphrase_files, (std::vector<std::filesystem::path>{"/run/old.psk"}));
}

}  // namespace
}  // namespace ddssec::governance::doctor
