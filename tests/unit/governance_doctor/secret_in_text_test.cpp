// Passwords and keys as each kind of configuration holds them.
#include "governance/doctor/secret_in_text.hpp"

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
                           "<PrivateKey>data:,-----BEGIN ENCRYPTED PRIVATE KEY-----"})
    EXPECT_TRUE(holds_secret(text)) << text;
}

TEST(SecretInText, EmptyPasswordOrTheNameOfAFile_IsNone) {
  for (const auto* text :
       {"", "<Password></Password>",
        "<Password>\n</Password><PrivateKey>file:/key.pem</PrivateKey>",
        "dds.sec.auth.password = file:/run/secrets/password\n", "dds.sec.auth.password =",
        "<property><name>dds.sec.auth.builtin.PKI-DH.password</name><value></value></property>",
        "<PrivateKey>file:/password.pem</PrivateKey>", "-----BEGIN CERTIFICATE-----"})
    EXPECT_FALSE(holds_secret(text)) << text;
}

}  // namespace
}  // namespace ddssec::governance::doctor
