// Parameters that come twice, have a false length, or must be understood.
#include "rtps/discovery/parameter_table.hpp"

#include <set>

#include <gmock/gmock.h>

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps/discovery_data.hpp"

namespace ddssec::rtps::discovery_data {
namespace {

using ::testing::AnyOf;
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

// An announcement, and how it is read.
struct Announcement {
  Bytes honest;
  Code (*read)(BytesView);
};

std::vector<Announcement> announcements() {
  return {
      {payload_of(participant()), [](BytesView o) { return code_of(read_participant_data(o)); }},
      {payload_of(publication()), [](BytesView o) { return code_of(read_publication_data(o)); }}};
}

// The last octet of a number in little endian: with it, the number exceeds the announcement.
constexpr std::uint8_t kHighOctets[] = {0x7f, 0x80, 0xff};

// Calls `f` with the octets of the announcement and a lie in the fourth octet at `at`.
template <class F>
void each_lie(const Announcement& announcement, std::size_t at, F&& f) {
  for (const auto high : kHighOctets) {
    auto octets = announcement.honest;
    octets[at + 3] = high;
    f(octets);
  }
}

// Calls `f` with the id and the place of each parameter of the list.
template <class F>
void each_parameter(const Announcement& announcement, F&& f) {
  const auto& octets = announcement.honest;
  for (std::size_t at = 4; at + 4 <= octets.size();) {
    const auto id = static_cast<ParameterId>(octets[at] | octets[at + 1] << 8);
    if (id == pid::kSentinel) return;
    f(id, at);
    at += 4u + static_cast<std::size_t>(octets[at + 2] | octets[at + 3] << 8);
  }
}

TEST(DiscoveryData, LyingLengthsOfParameters_AreRefused) {
  for (const auto& announcement : announcements()) {
    ASSERT_EQ(announcement.read(announcement.honest), Code{});
    int parameters = 0;
    each_parameter(announcement, [&](ParameterId id, std::size_t at) {
      ++parameters;
      each_lie(announcement, at, [&](const Bytes& octets) {
        EXPECT_EQ(announcement.read(octets), Code::truncated) << id;
      });
    });
    EXPECT_GT(parameters, 10);
  }
}

// CVE-2026-49861, -49862, -49863, -53589, -53590 and -55063 are about lists, locators, properties
// and partitions. Their values begin with a length or a count.
TEST(DiscoveryData, LyingCountsInParameters_AreRefused) {
  constexpr ParameterId kCounted[] = {
      pid::kDomainTag,         pid::kEntityName,   pid::kUserData,      pid::kTopicData,
      pid::kGroupData,         pid::kPropertyList, pid::kPartition,     pid::kDataTags,
      pid::kTopicName,         pid::kTypeName,     pid::kIdentityToken, pid::kPermissionsToken,
      pid::kDataRepresentation};
  std::set<ParameterId> tried;
  for (const auto& announcement : announcements())
    each_parameter(announcement, [&](ParameterId id, std::size_t at) {
      if (std::ranges::find(kCounted, id) == std::end(kCounted)) return;
      tried.insert(id);
      each_lie(announcement, at + 4, [&](const Bytes& octets) {
        EXPECT_THAT(announcement.read(octets), AnyOf(Code::truncated, Code::length_out_of_range))
            << id;
      });
    });
  EXPECT_EQ(tried.size(), std::size(kCounted)) << "the announcements have them all";
}

// A lie may turn a parameter into another one, whose value takes more room than its octets.
TEST(DiscoveryData, LiesAnywhere_AllocateLittleMoreThanTheTruth) {
  for (const auto& announcement : announcements()) {
    const auto allocated_by = [&](BytesView octets) {
      const auto before = counted_memory::octets_ever();
      static_cast<void>(announcement.read(octets));
      return counted_memory::octets_ever() - before;
    };
    const auto truth = allocated_by(announcement.honest);
    EXPECT_GT(truth, 0);
    const auto most = truth + static_cast<std::int64_t>(announcement.honest.size());
    for (std::size_t at = 4; at + 4 <= announcement.honest.size(); at += 4)
      each_lie(announcement, at,
               [&](const Bytes& octets) { EXPECT_LE(allocated_by(octets), most) << at; });
  }
}

TEST(DiscoveryData, MorePropertiesThanTheBound_AreRefused) {
  auto data = participant();
  data.properties.assign(kMaxProperties, {"a", "b"});
  EXPECT_EQ(code_of(read_participant_data(payload_of(data))), Code{});
  data.properties.push_back({"a", "b"});
  EXPECT_EQ(code_of(read_participant_data(payload_of(data))), Code::length_out_of_range);
}

TEST(DiscoveryData, OtherEncapsulations_AreRefused) {
  auto octets = payload_of(participant());
  octets[1] = 1;
  EXPECT_EQ(code_of(read_participant_data(octets)), Code::rtps_encapsulation_unsupported);
}

}  // namespace
}  // namespace ddssec::rtps::discovery_data
