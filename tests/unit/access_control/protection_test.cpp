// The attributes that the values of a governance document become, and what the plugins cannot do.
#include "plugins/access_control/protection.hpp"

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"

namespace ddssec::access_control {
namespace {

using governance::DomainRule;
using governance::TopicRule;

// Returns every algorithm that the plugins always use.
governance::AllowedAlgorithms algorithms() {
  governance::AllowedAlgorithms out;
  out.line = 9;
  out.key_establishment = {{"ECDHE-CEUM+P256", 0}};
  out.symmetric_cipher = {{"AES128+GCM", 0}, {"AES256+GCM", 0}};
  return out;
}

TEST(ParticipantAttributes, EachValue_IsThatOfItsElement) {
  DomainRule rule;
  rule.allow_unauthenticated_participants = false;
  rule.enable_join_access_control = true;
  rule.rtps_protection_kind = ProtectionKind::sign;
  rule.discovery_protection_kind = ProtectionKind::encrypt;
  rule.liveliness_protection_kind = ProtectionKind::none;
  rule.rtps_psk_protection_kind = ProtectionKind::sign_with_origin_authentication;
  rule.enable_key_revision = true;
  auto attributes = participant_attributes(rule);
  EXPECT_FALSE(attributes.allow_unauthenticated_participants);
  EXPECT_TRUE(attributes.is_access_protected);
  EXPECT_EQ(attributes.rtps, ProtectionKind::sign);
  EXPECT_EQ(attributes.discovery, ProtectionKind::encrypt);
  EXPECT_EQ(attributes.liveliness, ProtectionKind::none);
  EXPECT_EQ(attributes.rtps_psk, ProtectionKind::sign_with_origin_authentication);
  EXPECT_TRUE(attributes.is_key_revision_enabled);
  EXPECT_EQ(attributes.allowed_ciphers, spi::kAllCiphers);
  rule.allow_unauthenticated_participants = true;
  rule.enable_join_access_control = false;
  rule.enable_key_revision = false;
  attributes = participant_attributes(rule);
  EXPECT_TRUE(attributes.allow_unauthenticated_participants);
  EXPECT_FALSE(attributes.is_access_protected);
  EXPECT_FALSE(attributes.is_key_revision_enabled);
}

TEST(ParticipantAttributes, ListedCiphers_AreTheOnesAllowed) {
  DomainRule rule;
  rule.allowed_algorithms = algorithms();
  EXPECT_EQ(participant_attributes(rule).allowed_ciphers, spi::kAes128Bit | spi::kAes256Bit);
  rule.allowed_algorithms->symmetric_cipher = {{"a cipher of the future", 0}};
  EXPECT_EQ(participant_attributes(rule).allowed_ciphers, spi::CipherMask{0});
}

TEST(EndpointAttributes, EachValue_IsThatOfItsElement) {
  for (int value = 0; value < 4; ++value) {
    TopicRule rule;
    rule.enable_discovery_protection = value == 0;
    rule.enable_liveliness_protection = value == 1;
    rule.enable_read_access_control = value == 2;
    rule.enable_write_access_control = value == 3;
    rule.metadata_protection_kind = ProtectionKind::sign;
    rule.data_protection_kind = ProtectionKind::encrypt;
    const auto attributes = endpoint_attributes(rule);
    EXPECT_EQ(attributes.topic.is_discovery_protected, value == 0);
    EXPECT_EQ(attributes.topic.is_liveliness_protected, value == 1);
    EXPECT_EQ(attributes.topic.is_read_protected, value == 2);
    EXPECT_EQ(attributes.topic.is_write_protected, value == 3);
    EXPECT_EQ(attributes.submessage, ProtectionKind::sign);
    EXPECT_EQ(attributes.payload, ProtectionKind::encrypt);
    EXPECT_FALSE(attributes.is_builtin);
  }
}

// DDS-Security 1.2, clauses 7.5.13 and 9.4.2.9.24.
TEST(BuiltinAttributes, EachBuiltinTopic_HasTheProtectionOfItsContent) {
  DomainRule rule;
  rule.discovery_protection_kind = ProtectionKind::sign;
  rule.liveliness_protection_kind = ProtectionKind::encrypt_with_origin_authentication;
  const auto kind = [&](std::string_view topic) {
    const auto attributes = builtin_attributes(rule, topic);
    EXPECT_TRUE(attributes && attributes->is_builtin) << topic;
    EXPECT_EQ(attributes->payload, ProtectionKind::none) << topic;
    return attributes->submessage;
  };
  for (const char* const topic : {"DCPSParticipant", "DCPSPublication", "DCPSSubscription",
                                  "DCPSParticipantMessage", "DCPSParticipantStatelessMessage"})
    EXPECT_EQ(kind(topic), ProtectionKind::none) << topic;
  for (const char* const topic : {"DCPSParticipantSecure", "DCPSParticipantsSecure",
                                  "DCPSPublicationsSecure", "DCPSSubscriptionsSecure"})
    EXPECT_EQ(kind(topic), ProtectionKind::sign) << topic;
  EXPECT_EQ(kind("DCPSParticipantMessageSecure"),
            ProtectionKind::encrypt_with_origin_authentication);
  rule.discovery_protection_kind = ProtectionKind::none;
  EXPECT_EQ(kind("DCPSParticipantVolatileMessageSecure"), ProtectionKind::encrypt)
      << "keys are encrypted whatever the document says";
}

TEST(BuiltinAttributes, OtherTopics_HaveNone) {
  for (const char* const topic :
       {"", "Square", "DCPS", "DCPSParticipantSecureX", "dcpsparticipant"})
    EXPECT_FALSE(builtin_attributes({}, topic)) << topic;
}

TEST(CheckEnforceable, WhatTheHostCannotDo_IsRefusedByElement) {
  DomainRule rule;
  rule.line = 4;
  rule.rtps_psk_protection_kind = ProtectionKind::encrypt;
  auto refused = check_enforceable(rule, {});
  EXPECT_CODE(refused, governance_not_enforceable);
  EXPECT_EQ(refused.error().details().field, "<rtps_psk_protection_kind>");
  EXPECT_EQ(refused.error().details().line, 4);
  EXPECT_EQ(refused.error().details().found, "ENCRYPT");
  EXPECT_TRUE(check_enforceable(rule, {.host_has_pre_shared_keys = true}));
  rule.rtps_psk_protection_kind = ProtectionKind::none;
  rule.enable_key_revision = true;
  refused = check_enforceable(rule, {.host_has_pre_shared_keys = true});
  EXPECT_CODE(refused, governance_not_enforceable);
  EXPECT_EQ(refused.error().details().field, "<enable_key_revision>");
  EXPECT_TRUE(check_enforceable(rule, {.host_revises_keys = true}));
}

TEST(CheckEnforceable, ListWithoutAnAlgorithmThatIsAlwaysUsed_IsRefused) {
  DomainRule rule;
  rule.allowed_algorithms = algorithms();
  EXPECT_TRUE(check_enforceable(rule, {}));
  for (const char* const name : {"ECDH+prime256v1-CEUM", "ECDH+prime256v1"}) {
    rule.allowed_algorithms->key_establishment = {{name, 0}};
    EXPECT_TRUE(check_enforceable(rule, {})) << "the name of DDS-Security 1.1";
  }
  rule.allowed_algorithms->key_establishment = {{"ECDHE-CEUM+P384", 0}};
  auto refused = check_enforceable(rule, {});
  EXPECT_CODE(refused, governance_not_enforceable);
  EXPECT_EQ(refused.error().details().field, "<key_establishment>");
  EXPECT_EQ(refused.error().details().line, 9);
  for (const char* const only : {"AES128+GCM", "AES256+GCM"}) {
    rule.allowed_algorithms = algorithms();
    rule.allowed_algorithms->symmetric_cipher = {{only, 0}};
    refused = check_enforceable(rule, {});
    EXPECT_CODE(refused, governance_not_enforceable);
    EXPECT_EQ(refused.error().details().field, "<symmetric_cipher>");
    EXPECT_NE(refused.error().details().expected, only);
  }
}

}  // namespace
}  // namespace ddssec::access_control
