// Parameters that come twice, have a false length, or must be understood.
#include "rtps/discovery/parameter_table.hpp"

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "tests/unit/rtps/discovery_data.hpp"

namespace ddssec::rtps::discovery_data {
namespace {

using testing::code_of;

TEST(DiscoveryData, TheSameParameterTwice_IsRefused) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x34, 0, 4, 0}, {0x58, 0, 4, 0}))),
            Code::rtps_parameter_invalid);
}

TEST(DiscoveryData, WhatMustBeUnderstood_StopsTheSample) {
  EXPECT_EQ(code_of(read_participant_data(
                replaced(payload_of(participant()), {0x34, 0, 4, 0}, {0x34, 0x40, 4, 0}))),
            Code::rtps_parameter_not_understood);
}

// CVE-2026-49861, -49862, -49863, -53589, -53590 and -55063 are about lists, locators, properties
// and partitions.
TEST(DiscoveryData, LyingLengths_AreRefusedOrHarmless) {
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

TEST(DiscoveryData, OtherEncapsulations_AreRefused) {
  auto octets = payload_of(participant());
  octets[1] = 1;
  EXPECT_EQ(code_of(read_participant_data(octets)), Code::rtps_encapsulation_unsupported);
}

}  // namespace
}  // namespace ddssec::rtps::discovery_data
