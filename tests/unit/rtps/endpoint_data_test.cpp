#include "rtps/discovery/endpoint_data.hpp"

#include "rtps/discovery/participant_data.hpp"
#include "tests/unit/rtps/discovery_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps::discovery_data {
namespace {

using testing::code_of;

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

template <class T, class Read>
void expect_sound(const T& data, Read read) {
  for (auto endian : {Endian::little, Endian::big}) {
    const auto octets = payload_of(data, endian);
    EXPECT_EQ(read(octets), data);
    for (std::size_t size = 0; size < octets.size(); ++size)
      EXPECT_FALSE(read(BytesView(octets).first(size))) << size;
  }
}

// A peer's depth of 0 must not end the durability service.
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

TEST(DiscoveryData, EachByteOrder_RoundTripsAndEveryTruncationIsRefused) {
  expect_sound(participant(), read_participant_data);
  expect_sound(publication(), read_publication_data);
  expect_sound(subscription(), read_subscription_data);
}

TEST(DiscoveryData, AbsentPolicies_TakeTheirDefaults) {
  EndpointData plain;
  plain.guid = publication().guid;
  plain.topic_name = "t", plain.type_name = "T";
  plain.qos = default_writer_qos();
  auto octets = payload_of(plain);
  // Removes RELIABILITY (16 octets with its header), as a peer may leave it out.
  const Bytes reliability = {0x1a, 0, 12, 0};
  const auto at = std::ranges::search(octets, reliability).begin();
  octets.erase(at, at + 16);
  EXPECT_EQ(read_publication_data(octets), plain);
}

TEST(DiscoveryData, AnEndpoint_MustBeWhatItsTopicIsFor) {
  EXPECT_EQ(code_of(read_subscription_data(payload_of(publication()))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_publication_data(payload_of(subscription()))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, TypeConsistency_MayEndEarlyAndItsKindsAreBounded) {
  const auto octets = payload_of(subscription());
  const Bytes whole = {0x74, 0, 8, 0, 0, 0, 0, 0, 1, 1, 1};
  const auto read = [&](const Bytes& by) {
    return read_subscription_data(replaced(octets, whole, by));
  };
  // The first one has only two flags, and is followed by a parameter that no version defines.
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

// Found by fuzzing: the value was kept, but not written again.
TEST(DiscoveryData, AWritersTypeConsistency_SaysNothing) {
  const auto octets = payload_of(publication());
  // In the place of PRESENTATION stands the kind DISALLOW_TYPE_COERCION, without flags.
  const auto with = replaced(octets, {0x21, 0, 8, 0, 1, 0, 0, 0, 1, 1},  //
                             {0x74, 0, 8, 0, 0, 0, 0, 0, 0, 0});
  auto expected = publication();
  expected.qos.presentation = {};
  EXPECT_EQ(read_publication_data(with), expected);
  EXPECT_EQ(code_of(read_publication_data(replaced(with, {0x74, 0, 8, 0, 0}, {0x74, 0, 8, 0, 3}))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, AnotherParticipantsGuid_IsRefused) {
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x50, 0, 16, 0, 1}, {0x50, 0, 16, 0, 2}))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0, 0, 1, 0xc1}, {0, 0, 1, 0xc2}))),
            Code::rtps_parameter_invalid);
}

// If the name were accepted, the sets of the publisher that it names would wait for this writer.
TEST(DiscoveryData, AnotherParticipantsGroup_IsPassedOver) {
  auto data = publication();
  data.group_guid = Guid{data.guid.prefix, EntityId{{0, 0, 1, 8}}};
  EXPECT_EQ(read_publication_data(payload_of(data))->group_guid, data.group_guid);
  data.group_guid->prefix = {};
  EXPECT_FALSE(read_publication_data(payload_of(data))->group_guid);
}

// A dispose that names two endpoints ends neither of them.
TEST(DiscoveryData, TwoKeysInOne_AreRefused) {
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

TEST(DiscoveryData, EnumerationsBeyondTheirRange_AreRefused) {
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x1a, 0, 12, 0, 2}, {0x1a, 0, 12, 0, 3}))),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_publication_data(
                replaced(payload_of(publication()), {0x1d, 0, 4, 0, 1}, {0x1d, 0, 4, 0, 4}))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, KeysOfDisposes_AreRead) {
  std::array<std::uint8_t, 64> buffer{};
  SpanWriter out(buffer);
  write_endpoint_key(out, publication().guid);
  EXPECT_EQ(read_endpoint_key(out.view()), publication().guid);
  out.rewind(0);
  write_participant_key(out, participant().guid);
  EXPECT_EQ(read_participant_key(out.view()), participant().guid);
}

}  // namespace
}  // namespace ddssec::rtps::discovery_data
