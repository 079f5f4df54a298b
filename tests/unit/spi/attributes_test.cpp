#include "plugins/spi/attributes.hpp"

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

using enum ProtectionKind;

constexpr ProtectionKind kAll[] = {none, sign, encrypt, sign_with_origin_authentication,
                                   encrypt_with_origin_authentication};

TEST(ProtectionKindOfAttributes, Names_GoBothWaysAndNothingElseIsRead) {
  for (auto kind : kAll) EXPECT_EQ(protection_kind_from(to_string(kind)), kind);
  for (const char* text : {"", "none", "Encrypt", " SIGN", "SIGN "})
    EXPECT_EQ(protection_kind_from(text), std::nullopt) << text;
}

TEST(ProtectionKindOfAttributes, FlagsOfAMask_GiveItBack) {
  for (auto kind : kAll)
    EXPECT_EQ(
        protection_kind({is_protected(kind), is_encrypted(kind), is_origin_authenticated(kind)}),
        kind);
  EXPECT_EQ(protection_kind({.is_encrypted = true, .is_origin_authenticated = true}), none);
}

TEST(SecurityInfo, ParticipantMasks_AreAsTheStandardNumbersThem) {
  EXPECT_EQ(security_info(ParticipantSecurityAttributes{}),
            (SecurityInfo{0x80000000u, 0x80000000u}));
  const ParticipantSecurityAttributes all{.rtps = encrypt_with_origin_authentication,
                                          .discovery = encrypt,
                                          .liveliness = sign_with_origin_authentication};
  EXPECT_EQ(security_info(all), (SecurityInfo{0x80000007u, 0x8000002bu}));
  const auto psk = [](ProtectionKind kind) {
    return security_info(ParticipantSecurityAttributes{.rtps_psk = kind});
  };
  EXPECT_EQ(psk(sign), (SecurityInfo{0x80000010u, 0x80000000u}));
  EXPECT_EQ(psk(encrypt), (SecurityInfo{0x80000010u, 0x80000040u}));
  EXPECT_EQ(security_info(ParticipantSecurityAttributes{.is_key_revision_enabled = true}),
            (SecurityInfo{0x80000008u, 0x80000000u}));
}

TEST(SecurityInfo, EndpointMasks_AreAsTheStandardNumbersThem) {
  const EndpointSecurityAttributes a{
      .topic = {.is_read_protected = true, .is_liveliness_protected = true},
      .submessage = sign_with_origin_authentication,
      .payload = encrypt};
  EXPECT_EQ(security_info(a), (SecurityInfo{0x80000079u, 0x80000006u}));
}

TEST(SecurityInfo, OneInvalidMask_IsNotCompared) {
  const SecurityInfo a{0x80000001u, 0x80000001u};
  EXPECT_TRUE(is_compatible(a, a));
  EXPECT_FALSE(is_compatible(a, {0x80000003u, 0x80000001u}));
  EXPECT_FALSE(is_compatible(a, {0x80000001u, 0x80000000u}));
  EXPECT_TRUE(is_compatible(a, {0x00000003u, 0x80000001u}));
  EXPECT_TRUE(is_compatible(a, {0, 0}));
}

}  // namespace
}  // namespace ddssec::spi
