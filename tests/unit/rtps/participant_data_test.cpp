// What a participant announces about itself.
#include "rtps/discovery/participant_data.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/security_parameters.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/rtps/discovery_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps::discovery_data {
namespace {

using testing::code_of;

TEST(DiscoveryData, RequiredParameters_MustBeThere) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x58, 0, 4, 0}, {0x00, 0x0f, 4, 0}))),
            Code::rtps_parameter_missing);
  EXPECT_EQ(code_of(read_participant_key(Bytes{0, 3, 0, 0, 1, 0, 0, 0})),
            Code::rtps_parameter_missing);
}

TEST(DiscoveryData, Lists_AreBounded) {
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

TEST(DiscoveryData, WhatCycloneAnnouncesUnderRos_IsRead) {
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

TEST(DiscoveryData, TheLongSecurityInfoOfVersion12_IsRead) {
  const Bytes octets = {0x80, 0, 0, 1, 0x80, 0, 0, 2, 0, 1, 0, 1};
  Reader reader(octets);
  std::optional<spi::SecurityInfo> info;
  ASSERT_TRUE(read_security_info_into(reader, info));
  EXPECT_EQ(info, (spi::SecurityInfo{0x80000001, 0x80000002}));
}

}  // namespace
}  // namespace ddssec::rtps::discovery_data
