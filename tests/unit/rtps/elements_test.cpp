// Times, numbers, locators, entity ids, parameter lists and inline QoS.
#include <limits>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/entity_ids.hpp"
#include "wire/inline_qos.hpp"
#include "wire/locator.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;

TEST(Time, NanosecondsSurviveTheirFractions) {
  for (auto time :
       {0ns, 1ns, 999'999'999ns, 1'000'000'000ns, 1'500'000'001ns, -1ns, -2'500'000'000ns})
    EXPECT_EQ(Time::from(time).to_nanoseconds(), time) << time.count();
}

// CVE-2025-63829: some fractions made another stack loop for ever.
TEST(Time, EveryFractionConverts) {
  for (std::uint64_t fraction = 0; fraction <= 0xffffffff; fraction += 0x10001) {
    const Time time{{7, static_cast<std::uint32_t>(fraction)}};
    EXPECT_GE(time.to_nanoseconds(), 7s);
    EXPECT_LE(time.to_nanoseconds(), 8s);
  }
  EXPECT_LE((Time{{7, 0xffffffff}}).to_nanoseconds(), 8s);
}

TEST(Time, WhatDoesNotFitSaturates) {
  EXPECT_TRUE(Duration::from(std::chrono::nanoseconds::max()).is_infinite());
  EXPECT_EQ(kDurationInfinite.to_nanoseconds(), std::chrono::nanoseconds::max());
  EXPECT_EQ(Duration::from(std::chrono::nanoseconds::min()).seconds, INT32_MIN);
  EXPECT_EQ(to_string(kDurationInfinite), "infinite");
  EXPECT_EQ(to_string(Duration::from(1500ms)), "1.500 s");
}

TEST(NumberSet, HoldsWhatItReaches) {
  SequenceNumberSet set(SequenceNumber{10});
  EXPECT_TRUE(set.insert({10}));
  EXPECT_TRUE(set.insert({41}));
  EXPECT_TRUE(set.insert({42}));
  EXPECT_TRUE(set.insert({265}));
  EXPECT_FALSE(set.insert({266}));
  EXPECT_FALSE(set.insert({9}));
  EXPECT_EQ(set.size(), 256u);
  std::vector<std::int64_t> found;
  set.for_each([&](SequenceNumber number) { found.push_back(number.value); });
  EXPECT_EQ(found, (std::vector<std::int64_t>{10, 41, 42, 265}));
  EXPECT_TRUE(set.contains({42}));
  EXPECT_FALSE(set.contains({43}));
  EXPECT_FALSE(set.contains({INT64_MIN}));
}

TEST(Count, BeginsAgainBehindItsGreatest) {
  constexpr auto kMax = std::numeric_limits<std::int32_t>::max();
  constexpr auto kMin = std::numeric_limits<std::int32_t>::min();
  EXPECT_TRUE(is_later(2, 1));
  EXPECT_FALSE(is_later(1, 1));
  EXPECT_FALSE(is_later(1, 2));
  EXPECT_TRUE(is_later(kMin, kMax));
  EXPECT_FALSE(is_later(kMax, kMin));
  EXPECT_TRUE(is_later(-kMax, kMax - 65535));
  EXPECT_TRUE(is_later(kMax, 1));
}

TEST(NumberSet, BitsBeyondTheCountAreDropped) {
  const Bytes octets = {0, 0, 0, 3, 0xff, 0xff, 0xff, 0xff};
  Reader reader(octets);
  SequenceNumberSet set(SequenceNumber{1});
  ASSERT_TRUE(set.read_bits(reader));
  EXPECT_TRUE(set.contains({3}));
  EXPECT_FALSE(set.contains({4}));
}

TEST(Locator, TellsItsNature) {
  EXPECT_EQ(to_string(*Locator::parse("127.0.0.1", 7400)), "udp/127.0.0.1:7400");
  EXPECT_EQ(to_string(*Locator::parse("::1", 7400)), "udp/[::1]:7400");
  EXPECT_EQ(to_string(Locator{LocatorKind{16}, 1, {}}), "kind 16");
  EXPECT_TRUE(Locator::parse("239.255.0.1", 1)->is_multicast());
  EXPECT_TRUE(Locator::parse("ff02::1", 1)->is_multicast());
  EXPECT_TRUE(Locator::parse("::1", 1)->is_loopback());
  EXPECT_FALSE(Locator::parse("::2", 1)->is_loopback());
  EXPECT_FALSE(Locator::parse("0.0.0.0", 1)->is_usable());
  EXPECT_FALSE(Locator::parse("10.0.0.1", 0)->is_usable());
  EXPECT_FALSE(Locator::parse("::", 1)->is_usable());
  EXPECT_FALSE(Locator::parse("::ffff:0.0.0.0", 1)->is_usable());
  auto disguised = *Locator::parse("0.0.0.0", 1);
  disguised.address[3] = 1;
  EXPECT_FALSE(disguised.is_usable());
  EXPECT_TRUE(Locator::parse("::ffff:127.0.0.1", 1)->is_loopback());
  EXPECT_TRUE(Locator::parse("::ffff:239.255.0.1", 1)->is_multicast());
  EXPECT_FALSE(Locator::parse("localhost", 1));
  Locator out_of_range = *Locator::parse("10.0.0.1", 1);
  out_of_range.port = 0x10000;
  EXPECT_FALSE(out_of_range.is_usable());
}

TEST(EntityIds, KindsAreTold) {
  EXPECT_TRUE(is_builtin(kSpdpWriter) && is_writer(kSpdpWriter) && has_key(kSpdpWriter));
  EXPECT_TRUE(is_reader(kStatelessMessageReader) && !has_key(kStatelessMessageReader));
  EXPECT_TRUE(is_user_defined(EntityId{{0, 0, 1, 0x03}}));
  EXPECT_FALSE(is_writer(kEntityIdParticipant) || is_reader(kEntityIdParticipant));
}

Bytes list(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}
const Bytes kSentinel = {0, 1, 0, 0};

TEST(ParameterList, WalksToItsSentinelAndOverPadding) {
  const auto octets = list({{0, 0, 0, 4, 9, 9, 9, 9}, {0, 5, 0, 0}, kSentinel, {1, 2, 3}});
  ParameterReader reader(octets, Endian::big);
  EXPECT_EQ((*reader.next())->id, 5);
  EXPECT_FALSE(*reader.next());
  EXPECT_FALSE(*reader.next());
  EXPECT_EQ(parameter_list_prefix(octets, Endian::big)->size(), octets.size() - 3);
}

// Cyclone DDS #1555: the scan for a list's end.
TEST(ParameterList, EveryTruncationIsRefused) {
  const auto octets =
      list({{0, 5, 0, 4, 1, 2, 3, 4}, {0x40, 0, 0, 8, 1, 2, 3, 4, 5, 6, 7, 8}, kSentinel});
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_EQ(code_of(parameter_list_prefix(BytesView(octets).first(size), Endian::big)),
              Code::truncated);
}

TEST(ParameterList, OddAndLyingLengthsAreRefused) {
  for (std::uint8_t length : {1, 2, 3, 5})
    EXPECT_EQ(code_of(parameter_list_prefix(
                  list({{0, 5, 0, length, 1, 2, 3, 4, 5, 6, 7, 8}, kSentinel}), Endian::big)),
              Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(parameter_list_prefix(list({{0, 5, 0xff, 0xfc, 1, 2, 3, 4}, kSentinel}),
                                          Endian::big)),
            Code::truncated);
}

TEST(InlineQos, CoherenceRoundTrips) {
  for (auto endian : {Endian::big, Endian::little}) {
    Bytes octets(128);
    SpanWriter out(octets, endian);
    const InlineQos qos{{}, {}, {{5}, {(1ll << 40) + 6}, {7}, {1, 2, 3, 4}}};
    write(out, qos);
    EXPECT_FALSE(qos.empty());
    EXPECT_EQ(*read_inline_qos(out.view(), endian), qos);
  }
}

TEST(InlineQos, TheOriginalWriterRoundTripsAndImpossibleOnesAreRefused) {
  InlineQos qos;
  qos.original = {{GuidPrefix::from(Bytes(12, 7)), EntityId{{1, 2, 3, 4}}}, {(1ll << 40) + 6}};
  for (auto endian : {Endian::little, Endian::big}) {
    std::array<std::uint8_t, 64> buffer{};
    SpanWriter out(buffer, endian);
    write(out, qos);
    const auto octets = to_bytes(out.view());
    EXPECT_EQ(octets.size(), 4u + 24 + 4);
    EXPECT_EQ(read_inline_qos(octets, endian), qos);
    for (std::size_t size = 0; size < octets.size(); ++size)
      EXPECT_FALSE(read_inline_qos(BytesView(octets).first(size), endian)) << size;
  }
  Bytes with_list{0x61, 0, 28, 0};
  with_list.resize(4 + 16, 9);
  for (const std::uint8_t octet : {0, 0, 0, 0, 5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})
    with_list.push_back(octet);
  EXPECT_EQ(read_inline_qos(with_list, Endian::little)->original.number, SequenceNumber{5});
  auto bad = with_list;
  bad[24] = 0;
  EXPECT_EQ(code_of(read_inline_qos(bad, Endian::little)), Code::rtps_number_invalid);
  bad[20] = bad[21] = bad[22] = bad[23] = bad[24] = 0xff;
  EXPECT_EQ(code_of(read_inline_qos(bad, Endian::little)), Code::rtps_number_invalid);
  const Bytes tiny{0x61, 0, 4, 0, 1, 2, 3, 4, 1, 0, 0, 0};
  EXPECT_EQ(code_of(read_inline_qos(tiny, Endian::little)), Code::rtps_parameter_invalid);
}

TEST(InlineQos, AnUnknownSetIsNoneAndAnImpossibleOneIsRefused) {
  const Bytes unknown = {0, 0x56, 0, 8, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 1, 0, 0};
  EXPECT_TRUE(read_inline_qos(unknown, Endian::big)->empty());
  for (const std::uint8_t id : {0x56, 0x63, 0x64}) {
    const Bytes zero = {0, id, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0};
    EXPECT_EQ(code_of(read_inline_qos(zero, Endian::big)), Code::rtps_number_invalid);
    const Bytes tiny = {0, id, 0, 4, 0, 0, 0, 0, 0, 1, 0, 0};
    EXPECT_EQ(code_of(read_inline_qos(tiny, Endian::big)), Code::rtps_parameter_invalid);
  }
  const Bytes empty = {0, 0x65, 0, 0, 0, 1, 0, 0};
  EXPECT_EQ(code_of(read_inline_qos(empty, Endian::big)), Code::rtps_parameter_invalid);
}

TEST(InlineQos, RefusesWhatItMustUnderstandAndShortValues) {
  EXPECT_EQ(code_of(read_inline_qos(list({{0x40, 0x77, 0, 0}, kSentinel}), Endian::big)),
            Code::rtps_parameter_not_understood);
  EXPECT_TRUE(
      read_inline_qos(list({{0xc0, 0x77, 0, 0}, {0x05, 0x77, 0, 0}, kSentinel}), Endian::big));
  EXPECT_EQ(code_of(read_inline_qos(list({{0, 0x70, 0, 4, 1, 2, 3, 4}, kSentinel}), Endian::big)),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_inline_qos(list({{0, 0x71, 0, 0}, kSentinel}), Endian::big)),
            Code::rtps_parameter_invalid);
}

// Neither the first nor the last of two counts (SingleParameters).
TEST(InlineQos, AParameterThatComesTwice_IsRefused) {
  InlineQos qos;
  qos.key_hash.emplace().fill(7);
  qos.status.disposed = true;
  qos.coherence = {{5}, {6}, {7}, {1, 2, 3, 4}};
  qos.original = {{GuidPrefix::from(Bytes(12, 7)), EntityId{{1, 2, 3, 4}}}, {6}};
  qos.source_time = Time{{7, 0}};
  std::array<std::uint8_t, 256> buffer{};
  SpanWriter out(buffer);
  write(out, qos);
  const BytesView whole = out.view();
  ASSERT_EQ(read_inline_qos(whole, Endian::little), qos);
  ParameterReader parameters(whole, Endian::little);
  int repeated = 0;
  for (std::size_t at = 0;;) {
    const auto parameter = parameters.next();
    ASSERT_TRUE(parameter);
    if (!*parameter) break;
    auto twice = to_bytes(whole.subspan(at, parameters.consumed() - at));
    twice.insert(twice.end(), whole.begin(), whole.end());
    EXPECT_EQ(code_of(read_inline_qos(twice, Endian::little)), Code::rtps_parameter_invalid)
        << (*parameter)->id;
    at = parameters.consumed();
    ++repeated;
  }
  EXPECT_EQ(repeated, 8);
}

TEST(InlineQos, AnUnknownParameterThatComesTwice_IsSkipped) {
  EXPECT_TRUE(
      read_inline_qos(list({{0x05, 0x77, 0, 0}, {0x05, 0x77, 0, 0}, kSentinel}), Endian::big)
          ->empty());
  // Numbers of ours, with lengths that are not ours.
  EXPECT_TRUE(
      read_inline_qos(list({{0x8d, 0x5e, 0, 0}, {0x8d, 0x5e, 0, 0}, kSentinel}), Endian::big)
          ->empty());
}

TEST(InlineQos, StatusIsBigEndianInEitherList) {
  const Bytes octets = {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0};
  EXPECT_EQ(read_inline_qos(octets, Endian::little)->status, (StatusInfo{true, true}));
}

}  // namespace
}  // namespace ddssec::rtps
