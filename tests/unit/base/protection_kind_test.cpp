#include "base/protection_kind.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

using enum ProtectionKind;

TEST(ProtectionKind, SpellingOfDocuments_IsReadBack) {
  const std::pair<ProtectionKind, std::string_view> spelt[] = {
      {none, "NONE"},
      {sign, "SIGN"},
      {encrypt, "ENCRYPT"},
      {sign_with_origin_authentication, "SIGN_WITH_ORIGIN_AUTHENTICATION"},
      {encrypt_with_origin_authentication, "ENCRYPT_WITH_ORIGIN_AUTHENTICATION"}};
  for (const auto& [kind, text] : spelt) {
    EXPECT_EQ(to_string(kind), text);
    EXPECT_EQ(protection_kind_from(text), kind);
  }
}

TEST(ProtectionKind, AnotherSpelling_IsNoKind) {
  for (const char* text : {"", "none", "Encrypt", "ENCRYPT ", "SIGN_WITH_ORIGIN", "NONESIGN"})
    EXPECT_EQ(protection_kind_from(text), std::nullopt) << text;
}

// DDS-Security 1.2, clause 10.4.1.2.2.
TEST(ProtectionKind, EachKind_SaysWhatItProtects) {
  EXPECT_FALSE(is_protected(none));
  for (const auto kind :
       {sign, encrypt, sign_with_origin_authentication, encrypt_with_origin_authentication})
    EXPECT_TRUE(is_protected(kind));
  for (const auto kind : {none, sign, sign_with_origin_authentication})
    EXPECT_FALSE(is_encrypted(kind)) << to_string(kind);
  EXPECT_TRUE(is_encrypted(encrypt));
  EXPECT_TRUE(is_encrypted(encrypt_with_origin_authentication));
  for (const auto kind : {none, sign, encrypt})
    EXPECT_FALSE(is_origin_authenticated(kind)) << to_string(kind);
  EXPECT_TRUE(is_origin_authenticated(sign_with_origin_authentication));
  EXPECT_TRUE(is_origin_authenticated(encrypt_with_origin_authentication));
}

}  // namespace
}  // namespace ddssec
