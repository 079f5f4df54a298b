#include "plugins/cyclonedds/value_translation.hpp"

#include <algorithm>

#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr spi::ProtectionKind kKinds[] = {spi::ProtectionKind::none, spi::ProtectionKind::sign,
                                          spi::ProtectionKind::encrypt,
                                          spi::ProtectionKind::sign_with_origin_authentication,
                                          spi::ProtectionKind::encrypt_with_origin_authentication};

TEST(ValueTranslation, Guid_KeepsItsOctets) {
  Guid guid;
  for (std::uint8_t i = 0; i < 12; ++i) guid.prefix.octets[i] = i;
  guid.entity = kEntityIdParticipant;
  const auto c = to_c(guid);
  EXPECT_EQ(c.prefix[11], 11);
  EXPECT_EQ(c.entityId.entityKey[2], 0x01);
  EXPECT_EQ(c.entityId.entityKind, 0xc1);
  EXPECT_EQ(guid_from(c), guid);
}

TEST(ValueTranslation, ParticipantAttributesOfEveryKind_ComeBack) {
  for (const auto kind : kKinds) {
    const spi::ParticipantSecurityAttributes attributes{.allow_unauthenticated_participants = true,
                                                        .is_access_protected = false,
                                                        .rtps = kind,
                                                        .discovery = spi::ProtectionKind::encrypt,
                                                        .liveliness = kind};
    const auto c = to_c(attributes);
    EXPECT_EQ(c.is_rtps_protected != 0, kind != spi::ProtectionKind::none);
    EXPECT_TRUE(c.plugin_participant_attributes & spi::kMaskIsValid);
    EXPECT_EQ(c.ac_endpoint_properties._length, 0u);
    EXPECT_EQ(c.ac_endpoint_properties._buffer, nullptr);
    EXPECT_EQ(attributes_from(c), attributes);
  }
}

TEST(ValueTranslation, EndpointAttributesOfEveryKind_ComeBack) {
  for (const auto kind : kKinds) {
    for (const auto payload :
         {spi::ProtectionKind::none, spi::ProtectionKind::sign, spi::ProtectionKind::encrypt}) {
      const spi::EndpointSecurityAttributes attributes{
          .topic = {.is_read_protected = true, .is_liveliness_protected = true},
          .submessage = kind,
          .payload = payload};
      const auto c = to_c(attributes);
      EXPECT_TRUE(c.plugin_endpoint_attributes & spi::kMaskIsValid);
      EXPECT_EQ(c.is_key_protected != 0, payload == spi::ProtectionKind::encrypt);
      EXPECT_EQ(attributes_from(c), attributes);
    }
  }
}

TEST(ValueTranslation, WhatOurPluginsTellEachOther_ComesThrough) {
  for (const bool builtin : {false, true}) {
    spi::EndpointSecurityAttributes attributes;
    attributes.is_builtin = builtin;
    const auto c = to_c(attributes);
    EXPECT_EQ(c.ac_endpoint_properties._length, builtin ? 1u : 0u);
    EXPECT_EQ(attributes_from(c), attributes);
  }
  for (const auto ciphers : {spi::kStandardCiphers, spi::kAllCiphers})
    for (const bool all_discovery : {false, true}) {
      spi::ParticipantSecurityAttributes attributes;
      attributes.allowed_ciphers = ciphers;
      attributes.is_all_discovery_protected = all_discovery;
      EXPECT_EQ(attributes_from(to_c(attributes)), attributes);
    }
  DDS_Security_EndpointSecurityAttributes foreign{};
  DDS_Security_Property_t property{nullptr, nullptr, false};
  foreign.ac_endpoint_properties = {1, 1, &property};
  EXPECT_FALSE(attributes_from(foreign).is_builtin);
  foreign.ac_endpoint_properties = {1, 1, nullptr};
  EXPECT_FALSE(attributes_from(foreign).is_builtin);
}

// The core treats the reader as protected, so it matches it only with writers whose keys arrived.
// No keys ever arrive.
TEST(ValueTranslation, AClosedReader_IsProtectedForTheHostAndHasNoKeys) {
  const auto closed = closed_reader_attributes();
  EXPECT_TRUE(closed.is_submessage_protected);
  EXPECT_FALSE(closed.is_payload_protected);
  EXPECT_EQ(attributes_from(closed), spi::EndpointSecurityAttributes{});
}

TEST(ValueTranslation, MaskWithoutValidBit_MeansSigning) {
  DDS_Security_EndpointSecurityAttributes c{};
  c.is_submessage_protected = 1;
  c.plugin_endpoint_attributes = 7;
  EXPECT_EQ(attributes_from(c).submessage, spi::ProtectionKind::sign);
  DDS_Security_ParticipantSecurityAttributes p{};
  p.is_rtps_protected = 1;
  p.plugin_participant_attributes = 0x3f;
  EXPECT_EQ(attributes_from(p).rtps, spi::ProtectionKind::sign);
  EXPECT_EQ(attributes_from(p).discovery, spi::ProtectionKind::none);
}

TEST(ValueTranslation, EndpointQuestion_TakesPartitionsAndTags) {
  std::string a = "A", b = "B*", name = "level", value = "secret";
  DDS_Security_string names[] = {a.data(), b.data()};
  const DDS_Security_PartitionQosPolicy partition{{2, 2, names}};
  DDS_Security_Tag tag{name.data(), value.data()};
  const DDS_Security_DataTags tags{{1, 1, &tag}};
  const auto question = EndpointQuestion::from("Square", &partition, &tags);
  ASSERT_TRUE(question);
  const auto request = question->request();
  EXPECT_EQ(request.topic_name, "Square");
  EXPECT_THAT(request.partitions, testing::ElementsAre("A", "B*"));
  ASSERT_EQ(request.data_tags.size(), 1u);
  EXPECT_EQ(request.data_tags[0].name, "level");

  EXPECT_TRUE(EndpointQuestion::from("Square", nullptr, nullptr)->request().partitions.empty());
}

TEST(ValueTranslation, EndpointQuestion_RefusesNullParts) {
  EXPECT_EQ(EndpointQuestion::from(nullptr, nullptr, nullptr).error().code(), Code::null_argument);
  DDS_Security_string names[] = {nullptr};
  const DDS_Security_PartitionQosPolicy null_name{{1, 1, names}};
  EXPECT_EQ(EndpointQuestion::from("T", &null_name, nullptr).error().code(), Code::null_argument);
  const DDS_Security_PartitionQosPolicy no_buffer{{1, 1, nullptr}};
  EXPECT_EQ(EndpointQuestion::from("T", &no_buffer, nullptr).error().code(), Code::null_argument);
  DDS_Security_Tag tag{};
  const DDS_Security_DataTags tags{{1, 1, &tag}};
  EXPECT_EQ(EndpointQuestion::from("T", nullptr, &tags).error().code(), Code::null_argument);
}

TEST(ValueTranslation, SharedSecret_IsReadFromCyclonesLayout) {
  Bytes octets(32, 7);
  SharedSecretLayout layout{octets.data(), 32, {}, {}};
  std::ranges::fill(layout.challenge1, 1);
  std::ranges::fill(layout.challenge2, 2);
  const auto handle = reinterpret_cast<DDS_Security_SharedSecretHandle>(&layout);
  const auto secret = shared_secret_from(handle);
  ASSERT_TRUE(secret);
  secret->secret.expose([&](BytesView view) { EXPECT_TRUE(std::ranges::equal(view, octets)); });
  EXPECT_EQ(secret->challenge1[31], 1);
  EXPECT_EQ(secret->challenge2[0], 2);

  for (const auto& [size, pointer] : {std::pair{0, octets.data()},
                                      {-1, octets.data()},
                                      {65, octets.data()},
                                      {32, (DDS_Security_octet*)nullptr}}) {
    layout.shared_secret_size = size;
    layout.shared_secret = pointer;
    EXPECT_EQ(shared_secret_from(handle).error().code(), Code::foreign_shared_secret) << size;
  }
  EXPECT_EQ(shared_secret_from(0).error().code(), Code::foreign_shared_secret);
}

}  // namespace
}  // namespace ddssec::cyclonedds
