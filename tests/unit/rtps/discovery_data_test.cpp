#include <filesystem>
#include <fstream>
#include <iterator>

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

GuidPrefix prefix() { return GuidPrefix::from(Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}); }

ParticipantData participant() {
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

EndpointData publication() {
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

EndpointData subscription() {
  EndpointData data;
  data.guid = {prefix(), EntityId{{0, 0, 1, 0x07}}};
  data.topic_name = "Square";
  data.type_name = "ShapeType";
  data.qos.time_based_filter = {{1, 0}};
  data.qos.type_consistency = {
      TypeConsistencyKind::disallow_type_coercion, false, false, true, true, true};
  data.expects_inline_qos = true;
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

template <class T, class Read>
void expect_sound(const T& data, Read read) {
  for (auto endian : {Endian::little, Endian::big}) {
    const auto octets = payload_of(data, endian);
    EXPECT_EQ(read(octets), data);
    for (std::size_t size = 0; size < octets.size(); ++size)
      EXPECT_FALSE(read(BytesView(octets).first(size))) << size;
  }
}

// Before: a peer's depth of 0 ended the durability service.
TEST(DiscoveryData, ADurabilityServiceThatNoWriterCanHave_CountsAsTheDefault) {
  for (const DurabilityService& service :
       {DurabilityService{{{1, 0}}, {HistoryKind::keep_last, 0}, {}},
        DurabilityService{{{1, 0}}, {HistoryKind::keep_last, -7}, {}},
        DurabilityService{{{1, 0}}, {HistoryKind::keep_all, 1}, {-5, -1, -1}}}) {
    auto data = publication();
    data.qos.durability_service = service;
    const auto read = read_publication_data(payload_of(data));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->qos.durability_service, DurabilityService{});
  }
}

TEST(DiscoveryData, RoundTripsInBothByteOrdersAndRefusesEveryTruncation) {
  expect_sound(participant(), read_participant_data);
  expect_sound(publication(), read_publication_data);
  expect_sound(subscription(), read_subscription_data);
}

TEST(DiscoveryData, AbsentPoliciesTakeTheirDefaults) {
  EndpointData plain;
  plain.guid = publication().guid;
  plain.topic_name = "t", plain.type_name = "T";
  plain.qos = default_writer_qos();
  auto octets = payload_of(plain);
  // Cut out RELIABILITY (16 octets with its header) as a peer would leave it out.
  const Bytes reliability = {0x1a, 0, 12, 0};
  const auto at = std::ranges::search(octets, reliability).begin();
  octets.erase(at, at + 16);
  EXPECT_EQ(read_publication_data(octets), plain);
}

TEST(DiscoveryData, AnEndpointMustBeWhatItsTopicIsFor) {
  EXPECT_EQ(code_of(read_subscription_data(payload_of(publication()))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_publication_data(payload_of(subscription()))),
            Code::rtps_parameter_invalid);
}

Bytes replaced(Bytes octets, const Bytes& what, const Bytes& by) {
  const auto at = std::ranges::search(octets, what);
  EXPECT_FALSE(at.empty());
  std::ranges::copy(by, at.begin());
  return octets;
}

TEST(DiscoveryData, TypeConsistencyMayEndEarlyAndItsKindsAreBounded) {
  const auto octets = payload_of(subscription());
  const Bytes whole = {0x74, 0, 8, 0, 0, 0, 0, 0, 1, 1, 1};
  const auto read = [&](const Bytes& by) {
    return read_subscription_data(replaced(octets, whole, by));
  };
  // Two flags; then a parameter that nobody knows.
  EXPECT_EQ(read({0x74, 0, 4, 0, 0, 0, 0, 0, 0x00, 0x00, 0x00})->qos.type_consistency,
            (TypeConsistency{TypeConsistencyKind::disallow_type_coercion, false, false}));
  EXPECT_EQ(read({0x74, 0, 8, 0, 2, 0, 1, 1})->qos.type_consistency.kind,
            TypeConsistencyKind::allow_type_coercion);
  EXPECT_EQ(code_of(read({0x74, 0, 8, 0, 3, 0})), Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read({0x74, 0, 8, 0, 0xff, 0xff})), Code::rtps_parameter_invalid);
  EXPECT_EQ(payload_of(EndpointData{.guid = subscription().guid}).size() + 12,
            payload_of([] {
              EndpointData data{.guid = subscription().guid};
              data.qos.type_consistency.force_type_validation = true;
              return data;
            }())
                .size());
}

// Found by fuzzing: it was kept, and not written again.
TEST(DiscoveryData, AWritersTypeConsistencySaysNothing) {
  const auto octets = payload_of(publication());
  // In the place of PRESENTATION: the kind DISALLOW_TYPE_COERCION and no flag.
  const auto with = replaced(octets, {0x21, 0, 8, 0, 1, 0, 0, 0, 1, 1},  //
                             {0x74, 0, 8, 0, 0, 0, 0, 0, 0, 0});
  auto expected = publication();
  expected.qos.presentation = {};
  EXPECT_EQ(read_publication_data(with), expected);
  EXPECT_EQ(code_of(read_publication_data(replaced(with, {0x74, 0, 8, 0, 0}, {0x74, 0, 8, 0, 3}))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, AnotherParticipantsGuidIsRefused) {
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x50, 0, 16, 0, 1}, {0x50, 0, 16, 0, 2}))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0, 0, 1, 0xc1}, {0, 0, 1, 0xc2}))),
            Code::rtps_parameter_invalid);
}

// Before: it was believed, and the sets of the publisher that it named waited for this writer.
TEST(DiscoveryData, AnotherParticipantsGroupIsPassedOver) {
  auto data = publication();
  data.group_guid = Guid{data.guid.prefix, EntityId{{0, 0, 1, 8}}};
  EXPECT_EQ(read_publication_data(payload_of(data))->group_guid, data.group_guid);
  data.group_guid->prefix = {};
  EXPECT_FALSE(read_publication_data(payload_of(data))->group_guid);
}

TEST(DiscoveryData, RequiredParametersMustBeThere) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x58, 0, 4, 0}, {0x00, 0x0f, 4, 0}))),
            Code::rtps_parameter_missing);
  EXPECT_EQ(code_of(read_participant_key(Bytes{0, 3, 0, 0, 1, 0, 0, 0})),
            Code::rtps_parameter_missing);
}

TEST(DiscoveryData, TheSameParameterTwiceIsRefused) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x34, 0, 4, 0}, {0x58, 0, 4, 0}))),
            Code::rtps_parameter_invalid);
}

// A dispose that names two endpoints ends neither.
TEST(DiscoveryData, TwoKeysInOneAreRefused) {
  std::array<std::uint8_t, 64> buffer{};
  SpanWriter out(buffer);
  write_endpoint_key(out, publication().guid);
  constexpr std::size_t kEncapsulation = 4, kSentinel = 4;
  auto octets = to_bytes(out.view());
  octets.resize(octets.size() - kSentinel);
  EXPECT_EQ(read_endpoint_key(octets), publication().guid) << "without a sentinel";
  const auto parameter = to_bytes(BytesView(octets).subspan(kEncapsulation));
  octets.insert(octets.end(), parameter.begin(), parameter.end());
  octets.back() ^= 1;
  EXPECT_EQ(code_of(read_endpoint_key(octets)), Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, EnumerationsBeyondTheirRangeAreRefused) {
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x1a, 0, 12, 0, 2}, {0x1a, 0, 12, 0, 3}))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x1d, 0, 4, 0, 1}, {0x1d, 0, 4, 0, 4}))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, WhatMustBeUnderstoodStopsTheSample) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x34, 0, 4, 0}, {0x34, 0x40, 4, 0}))),
            Code::rtps_parameter_not_understood);
}

// CVE-2026-49861, -49862, -49863, -53589, -53590, -55063: lists, locators, properties, partitions.
TEST(DiscoveryData, LyingLengthsAreRefusedOrHarmless) {
  for (const auto& honest : {payload_of(participant()), payload_of(publication())}) {
    for (std::size_t at = 4; at + 4 <= honest.size(); at += 4) {
      for (std::uint8_t high : {0x01, 0x7f, 0x80, 0xff}) {
        auto octets = honest;
        octets[at + 3] = high;
        const auto a = read_participant_data(octets);
        const auto b = read_publication_data(octets);
        EXPECT_LE(a ? a->properties.size() : 0, kMaxProperties);
        EXPECT_LE(b ? b->qos.partition.size() : 0, kMaxPartitions);
      }
    }
  }
}

TEST(DiscoveryData, ListsAreBounded) {
  auto data = participant();
  data.metatraffic_unicast.assign(kMaxLocators + 1, *Locator::parse("10.0.0.1", 1));
  EXPECT_EQ(code_of(read_participant_data(payload_of(data))), Code::length_out_of_range);
  auto endpoint = publication();
  endpoint.qos.partition.assign(kMaxPartitions + 1, "p");
  EXPECT_EQ(code_of(read_publication_data(payload_of(endpoint))), Code::length_out_of_range);
  endpoint = publication();
  endpoint.qos.data_tags.assign(kMaxDataTags + 1, {"a", "b"});
  EXPECT_EQ(code_of(read_publication_data(payload_of(endpoint))), Code::length_out_of_range);
  endpoint = publication();
  endpoint.topic_name.assign(kMaxNameLength + 1, 't');
  EXPECT_EQ(code_of(read_publication_data(payload_of(endpoint))), Code::length_out_of_range);
}

TEST(DiscoveryData, OtherEncapsulationsAreRefused) {
  auto octets = payload_of(participant());
  octets[1] = 1;
  EXPECT_EQ(code_of(read_participant_data(octets)), Code::rtps_encapsulation_unsupported);
}

TEST(DiscoveryData, KeysOfDisposes) {
  std::array<std::uint8_t, 64> buffer{};
  SpanWriter out(buffer);
  write_endpoint_key(out, publication().guid);
  EXPECT_EQ(read_endpoint_key(out.view()), publication().guid);
  out.rewind(0);
  write_participant_key(out, participant().guid);
  EXPECT_EQ(read_participant_key(out.view()), participant().guid);
}

TEST(DiscoveryData, WhatCycloneAnnouncesUnderRosIsRead) {
  int read = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::data_path("fuzz/discovery_data"))) {
    std::ifstream in(entry.path(), std::ios::binary);
    const Bytes octets{std::istreambuf_iterator<char>(in), {}};
    EXPECT_TRUE(read_participant_data(octets) || read_publication_data(octets) ||
                read_subscription_data(octets) || read_participant_key(octets) ||
                read_endpoint_key(octets))
        << entry.path();
    ++read;
  }
  EXPECT_GT(read, 10);
}

TEST(DiscoveryData, TheLongSecurityInfoOfVersion12IsRead) {
  const Bytes octets = {0x80, 0, 0, 1, 0x80, 0, 0, 2, 0, 1, 0, 1};
  Reader reader(octets);
  std::optional<spi::SecurityInfo> info;
  ASSERT_TRUE(read_security_info_into(reader, info));
  EXPECT_EQ(info, (spi::SecurityInfo{0x80000001, 0x80000002}));
}

}  // namespace
}  // namespace ddssec::rtps
