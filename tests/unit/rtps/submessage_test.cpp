// Every submessage: written and read alike in both byte orders, refused at every truncation.
#include <functional>

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/acknack.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/header_extension.hpp"
#include "wire/heartbeat.hpp"
#include "wire/heartbeat_frag.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_reply.hpp"
#include "wire/info_source.hpp"
#include "wire/info_timestamp.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {
namespace {

using ::testing::AnyOf;
using testing::code_of;
using testing::kReader;
using testing::kWriter;
using testing::view_of;
using testing::written;

SequenceNumberSet set_of(std::initializer_list<std::int64_t> numbers) {
  SequenceNumberSet set(SequenceNumber{*numbers.begin()});
  for (auto number : numbers) EXPECT_TRUE(set.insert({number}));
  return set;
}

/// Round trip in both byte orders, and every truncation of the body is refused.
template <class S, class Read>
void expect_round_trip(const S& submessage, Read read) {
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(submessage, endian);
    const auto view = view_of(octets);
    const auto copy = read(view);
    ASSERT_TRUE(copy) << copy.error().to_sentence();
    EXPECT_EQ(*copy, submessage);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_THAT(code_of(read(cut)), AnyOf(Code::truncated, Code::length_out_of_range)) << size;
    }
  }
}

TEST(Submessage, AckNack) {
  expect_round_trip(AckNack{kReader, kWriter, set_of({5, 6, 260}), 7, false}, read_acknack);
  expect_round_trip(AckNack{kReader, kWriter, SequenceNumberSet({(1ll << 40) + 3}), -1, true},
                    read_acknack);
  // Fast DDS begins with base 0.
  expect_round_trip(AckNack{kReader, kWriter, SequenceNumberSet({0}), 0, false}, read_acknack);
}

TEST(Submessage, Heartbeat) {
  expect_round_trip(Heartbeat{kReader, kWriter, {1}, {9}, 3, true, true}, read_heartbeat);
  expect_round_trip(Heartbeat{{}, kWriter, {10}, {9}, 3, false, false}, read_heartbeat);
}

TEST(Submessage, Gap) { expect_round_trip(Gap{kReader, kWriter, {4}, set_of({8, 10})}, read_gap); }

TEST(Submessage, GapOfAGroup) {
  Gap gap{kReader, kWriter, {4}, set_of({8, 10}), {}};
  gap.group = {{7}, {9}};
  expect_round_trip(gap, read_gap);
  gap.group = {{7}, {6}};  // none
  expect_round_trip(gap, read_gap);
  for (const auto& bad : {std::pair(SequenceNumber{0}, SequenceNumber{6}),
                          std::pair(SequenceNumber{7}, SequenceNumber{5}),
                          std::pair(SequenceNumber{7}, SequenceNumber{(1ll << 62) + 1})}) {
    gap.group = bad;
    EXPECT_EQ(code_of(read_gap(view_of(written(gap)))), Code::rtps_number_invalid);
  }
}

TEST(Submessage, HeartbeatOfAGroup) {
  Heartbeat heartbeat{kReader, kWriter, {1}, {9}, 3, true, false, {}};
  heartbeat.group = GroupState{{40}, {12}, {30}, {1, 2, 3, 4}, {5, 6, 7, 8}};
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(heartbeat, endian);
    const auto view = view_of(octets);
    EXPECT_EQ(*read_heartbeat(view), heartbeat);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      // Some say nothing of the writers.
      const bool without_writers = size == view.body.size() - 8;
      EXPECT_EQ(read_heartbeat(cut).has_value(), without_writers) << size;
    }
  }
  const auto refused = [&](const GroupState& group) {
    heartbeat.group = group;
    return code_of(read_heartbeat(view_of(written(heartbeat))));
  };
  constexpr SequenceNumber kHuge{(1ll << 62) + 1};
  EXPECT_EQ(refused({{-1}, {1}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({kHuge, {1}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {0}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {3}, {1}, {}, {}}), Code::rtps_number_invalid);
  EXPECT_EQ(refused({{1}, {1}, kHuge, {}, {}}), Code::rtps_number_invalid);
}

TEST(Submessage, NackFrag) {
  FragmentNumberSet missing(FragmentNumber{2});
  missing.insert({40});
  expect_round_trip(NackFrag{kReader, kWriter, {3}, missing, 5}, read_nack_frag);
}

TEST(Submessage, HeartbeatFrag) {
  expect_round_trip(HeartbeatFrag{kReader, kWriter, {3}, {4}, 5}, read_heartbeat_frag);
}

TEST(Submessage, Infos) {
  const auto prefix = GuidPrefix::from(Bytes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  expect_round_trip(InfoTimestamp{Time{{100, 1u << 31}}}, read_info_timestamp);
  expect_round_trip(InfoDestination{prefix}, read_info_destination);
  expect_round_trip(InfoSource{Header{kProtocolVersion, kVendorCyclone, prefix}}, read_info_source);
  expect_round_trip(InfoReply{*Locator::parse("10.0.0.1", 7400), {}}, read_info_reply);
  expect_round_trip(InfoReply{*Locator::parse("::1", 1), *Locator::parse("239.255.0.1", 2)},
                    read_info_reply);
}

TEST(Submessage, AnInvalidatedTimestampHasNoBody) {
  const auto octets = written(InfoTimestamp{});
  EXPECT_EQ(octets.size(), kSubmessageHeaderSize);
  EXPECT_EQ(read_info_timestamp(view_of(octets))->time, std::nullopt);
}

TEST(Submessage, HeaderExtension) {
  expect_round_trip(HeaderExtension{100, Time{{5, 6}}},
                    [](const auto& view) { return read_header_extension(view, 100); });
}

TEST(Submessage, AHeaderExtensionWithAnotherLengthIsRefused) {
  const auto octets = written(HeaderExtension{.message_length = 100});
  EXPECT_EQ(code_of(read_header_extension(view_of(octets), 99)), Code::rtps_submessage_overrun);
}

TEST(Submessage, AllPartsOfAHeaderExtensionAreSteppedOver) {
  const Bytes body = {100, 0, 0, 0,                           // length
                      1,   0, 0, 0, 2, 0, 0, 0,               // time
                      0,   0, 0, 0,                           // U
                      0,   0, 0, 0, 0, 0, 0, 0,               // W
                      0,   0, 0, 0,                           // CRC-32C
                      5,   0, 4, 0, 1, 2, 3, 4, 1, 0, 0, 0};  // parameters
  SubmessageView view{SubmessageId::header_extension, 0xbf, body, body};
  EXPECT_TRUE(read_header_extension(view, 100));
  for (std::size_t size = 0; size < body.size(); ++size) {
    view.body = BytesView(body).first(size);
    EXPECT_EQ(code_of(read_header_extension(view, 100)), Code::truncated) << size;
  }
}

// Found by fuzzing: an address of no kind of transport is none.
TEST(Submessage, AnInfoReplyToALocatorWithoutAKindIsToNone) {
  Bytes octets = {0x0f, 1, 28, 0, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};
  octets.resize(32, 0xff);
  const auto view = MessageReader::over_submessages({}, octets).next();
  ASSERT_TRUE(view && *view);
  EXPECT_EQ(read_info_reply(**view), InfoReply{});
}

TEST(Submessage, InfoReplyIp4) {
  const Bytes body = {1, 0, 0, 127, 0xe8, 0x1c, 0, 0};  // little endian 127.0.0.1:7400
  SubmessageView view{SubmessageId::info_reply_ip4, 1, body, body};
  EXPECT_EQ(read_info_reply_ip4(view)->unicast, Locator::udp_v4({127, 0, 0, 1}, 7400));
}

Data sample_data(BytesView payload) {
  Data data{kReader, kWriter, {77}, {}, PayloadKind::data, payload};
  data.inline_qos.key_hash = KeyHash{1, 2, 3};
  data.inline_qos.status.disposed = true;
  return data;
}

TEST(Submessage, Data) {
  const Bytes payload = {0, 1, 0, 0, 9, 8, 7, 6};
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(sample_data(payload), endian);
    const auto view = view_of(octets);
    const auto copy = read_data(view);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->sequence_number.value, 77);
    EXPECT_EQ(copy->inline_qos, sample_data(payload).inline_qos);
    EXPECT_EQ(to_bytes(copy->payload), payload);
    // Only the payload has no length of its own.
    for (std::size_t size = 0; size < view.body.size() - payload.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_EQ(code_of(read_data(cut)), Code::truncated) << size;
    }
  }
}

TEST(Submessage, DataWithDataAndKeyAtOnceIsRefused) {
  auto octets = written(sample_data(Bytes{0, 1, 0, 0}));
  octets[1] |= 0x08;
  EXPECT_EQ(code_of(read_data(view_of(octets))), Code::malformed);
}

TEST(Submessage, TheOffsetToTheInlineQosStaysInside) {
  for (std::uint8_t offset : {0, 4, 15, 200, 255}) {
    auto octets = written(sample_data(Bytes{0, 1, 0, 0}));
    octets[6] = offset;
    EXPECT_EQ(code_of(read_data(view_of(octets))), Code::rtps_submessage_overrun) << int{offset};
  }
}

DataFrag sample_frag(BytesView payload) {
  DataFrag frag{kReader, kWriter, {5}, {2}, 2, 8, 20, {}, false, payload};
  frag.inline_qos.key_hash = KeyHash{9};
  return frag;
}

TEST(Submessage, DataFrag) {
  const Bytes payload(12, 0xaa);  // fragment 2 whole, fragment 3 with the last 4 octets
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(sample_frag(payload), endian);
    const auto view = view_of(octets);
    const auto copy = read_data_frag(view);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->total(), 3u);
    EXPECT_EQ(to_bytes(copy->payload), payload);
    EXPECT_EQ(copy->inline_qos, sample_frag(payload).inline_qos);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_EQ(code_of(read_data_frag(cut)), Code::truncated) << size;
    }
  }
}

// CVE-2023-50716, CVE-2025-62799, CVE-2026-22590, CVE-2025-65865.
TEST(Submessage, FragmentsMustLieInsideTheirSample) {
  const Bytes payload(64, 0);
  auto lying = [&](auto&& change) {
    auto frag = sample_frag(payload);
    change(frag);
    return code_of(read_data_frag(view_of(written(frag))));
  };
  EXPECT_EQ(lying([](auto& f) { f.first = {0}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.first = {4}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.first = {0xffffffff}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.count = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.count = 3; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.fragment_size = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.sample_size = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.fragment_size = 65535, f.sample_size = 0xffffffff; }),
            Code::truncated);
}

TEST(Submessage, NumbersOutOfRangeAreRefused) {
  using F = std::function<Code()>;
  const std::int64_t huge = (std::int64_t{1} << 62) + 1;
  const F cases[] = {
      [] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {0}, {3}}))));
      },
      [] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {5}, {3}}))));
      },
      [=] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {1}, {huge}}))));
      },
      [=] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, {}, {huge}, {huge}}))));
      },
      [] {
        return code_of(read_acknack(view_of(written(AckNack{{}, {}, SequenceNumberSet({-1})}))));
      },
      [=] {
        return code_of(read_acknack(view_of(written(AckNack{{}, {}, SequenceNumberSet({huge})}))));
      },
      [] {
        return code_of(
            read_nack_frag(view_of(written(NackFrag{{}, {}, {1}, FragmentNumberSet({0})}))));
      },
      [] {
        return code_of(read_nack_frag(
            view_of(written(NackFrag{{}, {}, {1}, FragmentNumberSet({0xffffff80})}))));
      },
      [] {
        return code_of(read_heartbeat_frag(view_of(written(HeartbeatFrag{{}, {}, {1}, {0}}))));
      },
      [] {
        return code_of(read_data(view_of(written(Data{{}, {}, {0}}))));
      },
      [] {
        return code_of(read_data(view_of(written(Data{{}, {}, {-1}}))));
      },
  };
  for (const auto& refused : cases) EXPECT_EQ(refused(), Code::rtps_number_invalid);
}

// CVE-2023-39534 and CVE-2025-64438: a GAP is a range, and it is read in constant time and memory.
TEST(Submessage, GapRangesAreCheckedAndNeverWalked) {
  Gap backwards{kReader, kWriter, {10}, SequenceNumberSet({9})};
  EXPECT_EQ(code_of(read_gap(view_of(written(backwards)))), Code::rtps_number_invalid);
  Gap zero{kReader, kWriter, {0}, SequenceNumberSet({1})};
  EXPECT_EQ(code_of(read_gap(view_of(written(zero)))), Code::rtps_number_invalid);
  Gap wide{kReader, kWriter, {1}, SequenceNumberSet(kMaxSequenceNumber)};
  EXPECT_EQ(read_gap(view_of(written(wide)))->list.base(), kMaxSequenceNumber);
}

// CVE-2020-18734: bit counts beyond the bitmap.
TEST(Submessage, SetsOfMoreThan256BitsAreRefused) {
  const auto honest = written(AckNack{kReader, kWriter, set_of({5, 6})});
  for (std::uint32_t bits : {257u, 288u, 0x7fffffffu, 0xffffffffu}) {
    auto octets = honest;
    for (int i = 0; i < 4; ++i) octets[20 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
    EXPECT_EQ(code_of(read_acknack(view_of(octets))), Code::rtps_set_invalid) << bits;
  }
}

TEST(Submessage, WhatDoesNotFitTheBufferIsNoticed) {
  std::array<std::uint8_t, 30> small{};
  SpanWriter out(small);
  write(out, AckNack{kReader, kWriter, set_of({5, 6}), 1, true});
  EXPECT_TRUE(out.overflowed());
  out.rewind(0);
  write(out, InfoDestination{});
  EXPECT_FALSE(out.overflowed());
  EXPECT_EQ(out.size(), 16u);
}

}  // namespace
}  // namespace ddssec::rtps
