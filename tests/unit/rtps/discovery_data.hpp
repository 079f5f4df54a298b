// Sample announcements of participants and endpoints.
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps::discovery_data {

inline GuidPrefix prefix() {
  return GuidPrefix::from(Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
}

inline ParticipantData participant() {
  ParticipantData data;
  data.guid = {prefix(), kEntityIdParticipant};
  data.vendor = kVendorDdssec;
  data.domain_id = 7;
  data.domain_tag = "tag";
  data.builtin_endpoints = 0x0fff0c3f;
  data.lease_duration = {{11, 5}};
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7410), *Locator::parse("::1", 7410)};
  data.metatraffic_multicast = {*Locator::parse("239.255.0.1", 7400)};
  data.default_unicast = {*Locator::parse("127.0.0.1", 7411)};
  data.manual_liveliness_count = 3;
  data.entity_name = "name";
  data.user_data = {1, 2, 3};
  data.properties = {{"a", "b"}};
  data.identity_token = spi::Token{"DDS:Auth:PKI-DH:1.0", {{"dds.cert.sn", "CN=a"}}, {}};
  data.permissions_token = spi::Token{"DDS:Access:Permissions:1.0", {}, {}};
  data.security_info = spi::SecurityInfo{0x80000007, 0x80000001};
  data.ciphers = spi::SymmetricCipherInfo{0x00010003, 0x2, 0x1, 0x00010000};
  return data;
}

inline EndpointData publication() {
  EndpointData data;
  data.guid = {prefix(), EntityId{{0, 0, 1, 0x02}}};
  data.topic_name = "Square";
  data.type_name = "ShapeType";
  auto& qos = data.qos;
  qos.reliability = {ReliabilityKind::reliable, {{1, 2}}};
  qos.durability = DurabilityKind::transient_local;
  qos.durability_service = {{{1, 0}}, {HistoryKind::keep_all, 3}, {1, 2, 3}};
  qos.history = {HistoryKind::keep_last, 64};
  qos.resource_limits = {10, 20, 5};
  qos.deadline = {{3, 0}};
  qos.latency_budget = {{0, 7}};
  qos.lifespan = {{9, 0}};
  qos.liveliness = {LivelinessKind::manual_by_topic, {{4, 0}}};
  qos.ownership = OwnershipKind::exclusive;
  qos.ownership_strength = -5;
  qos.destination_order = DestinationOrderKind::by_source;
  qos.presentation = {PresentationScope::topic, true, true};
  qos.partition = {"a", "b*"};
  qos.data_tags = {{"level", "open"}, {"", ""}};
  qos.transport_priority = 2;
  qos.data_representation = {DataRepresentation::xcdr2, DataRepresentation::xcdr1};
  qos.user_data = {1}, qos.topic_data = {2, 2}, qos.group_data = {3, 3, 3};
  data.unicast = {*Locator::parse("10.0.0.1", 1)};
  data.multicast = {*Locator::parse("239.1.1.1", 2)};
  data.security_info = spi::SecurityInfo{0x8000001b, 0x80000001};
  data.required_ciphers = 0x00010000;
  return data;
}

template <class T>
Bytes payload_of(const T& data, Endian endian = Endian::little) {
  std::array<std::uint8_t, 4096> buffer{};
  SpanWriter out(buffer, endian);
  write_payload(out, data);
  EXPECT_FALSE(out.overflowed());
  return to_bytes(out.view());
}

inline Bytes replaced(Bytes octets, const Bytes& what, const Bytes& by) {
  const auto at = std::ranges::search(octets, what);
  EXPECT_FALSE(at.empty());
  std::ranges::copy(by, at.begin());
  return octets;
}

}  // namespace ddssec::rtps::discovery_data
