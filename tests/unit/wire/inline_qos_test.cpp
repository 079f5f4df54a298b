// What inline QoS says, and what is refused in it.
#include "wire/inline_qos.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/parameters.hpp"
#include "wire/numbers.hpp"
#include "wire/parameter_list.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps::parameters {
namespace {

using namespace std::chrono_literals;
using testing::code_of;

const Bytes kSentinel = {0, 1, 0, 0};

TEST(InlineQos, Coherence_RoundTrips) {
  for (auto endian : {Endian::big, Endian::little}) {
    Bytes octets(128);
    SpanWriter out(octets, endian);
    const InlineQos qos{{}, {}, {{5}, {(1ll << 40) + 6}, {7}, {1, 2, 3, 4}}};
    write(out, qos);
    EXPECT_FALSE(qos.empty());
    EXPECT_EQ(*read_inline_qos(out.view(), endian), qos);
  }
}

TEST(InlineQos, OriginalWriter_RoundTripsAndImpossibleOnesAreRefused) {
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

TEST(InlineQos, AnUnknownSet_IsNoneAndAnImpossibleOneIsRefused) {
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

TEST(InlineQos, UnknownParametersThatMatterAndShortValues_AreRefused) {
  EXPECT_EQ(code_of(read_inline_qos(list({{0x40, 0x77, 0, 0}, kSentinel}), Endian::big)),
            Code::rtps_parameter_not_understood);
  EXPECT_TRUE(
      read_inline_qos(list({{0xc0, 0x77, 0, 0}, {0x05, 0x77, 0, 0}, kSentinel}), Endian::big));
  EXPECT_EQ(code_of(read_inline_qos(list({{0, 0x70, 0, 4, 1, 2, 3, 4}, kSentinel}), Endian::big)),
            Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(read_inline_qos(list({{0, 0x71, 0, 0}, kSentinel}), Endian::big)),
            Code::rtps_parameter_invalid);
}

// Neither the first nor the last one of two counts (SingleParameters).
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
  // These have the ids of our parameters, but other lengths.
  EXPECT_TRUE(
      read_inline_qos(list({{0x8d, 0x5e, 0, 0}, {0x8d, 0x5e, 0, 0}, kSentinel}), Endian::big)
          ->empty());
}

TEST(InlineQos, Status_IsBigEndianInEitherList) {
  const Bytes octets = {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0};
  EXPECT_EQ(read_inline_qos(octets, Endian::little)->status, (StatusInfo{true, true}));
}

}  // namespace
}  // namespace ddssec::rtps::parameters
