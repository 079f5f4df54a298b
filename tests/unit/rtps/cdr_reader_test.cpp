#include "rtps/cdr/cdr_reader.hpp"

#include <gmock/gmock.h>

#include "rtps/cdr/cdr_writer.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps/cdr_types.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using ::testing::AnyOf;
using testing::code_of;

Everything everything() {
  return {true,      -2,     2.5,     0.5f,      Colour::green,
          {1, 2, 3}, {7, 8}, {-1, 1}, {"a", ""}, {{1, 2}, {3, 4}},
          {5, 6}};
}

TEST(Cdr, EveryEncoding_RoundTrips) {
  Bytes out;
  for (auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
    for (auto endian : {Endian::big, Endian::little}) {
      serialize(everything(), out, version, endian);
      EXPECT_EQ(deserialize<Everything>(out), everything());
      serialize(Shape{"RED", -1, 2, 3}, out, version, endian);
      EXPECT_EQ(deserialize<Shape>(out), (Shape{"RED", -1, 2, 3}));
      serialize_key(Shape{"RED", -1, 2, 3}, out, version, endian);
      EXPECT_EQ(deserialize_key<Shape>(out), (Shape{"RED", 0, 0, 0}));
    }
  }
}

TEST(Cdr, EveryTruncation_IsRefusedOrAnOlderVersion) {
  Bytes out;
  for (auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
    serialize(everything(), out, version);
    for (std::size_t size = 0; size < out.size(); ++size) {
      const auto read = deserialize<Everything>(BytesView(out).first(size));
      EXPECT_FALSE(version == XcdrVersion::xcdr2 && read) << size;
      EXPECT_NE(read, everything());
    }
    serialize(Shape{"RED", 1, 2, 3}, out, version);
    for (std::size_t size = 0; size < out.size(); ++size)
      EXPECT_EQ(code_of(deserialize<Shape>(BytesView(out).first(size))), Code::truncated);
  }
}

TEST(Cdr, AppendableTypes_ReadOlderAndNewerWriters) {
  Bytes out;
  for (auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
    serialize(everything(), out, version);
    EXPECT_EQ(deserialize<Less>(out), (Less{true, -2}));
    serialize(Less{true, 9}, out, version);
    Everything expected;
    expected.flag = true, expected.small = 9;
    EXPECT_EQ(deserialize<Everything>(out), expected);
  }
}

// CVE-2020-18735, CVE-2023-23932, and the sequences of CVE-2026-45097 and -49861 claim 2^31
// elements.
TEST(Cdr, LyingCounts_AreRefused) {
  Bytes honest;
  serialize(everything(), honest);
  // Of `octets`, of `wide`, of `texts` and of each text, and of `inners`.
  const std::pair<std::size_t, std::uint8_t> counts[] = {{36, 2}, {44, 2}, {68, 2},
                                                         {72, 2}, {80, 1}, {88, 2}};
  for (const auto& [at, count] : counts) {
    ASSERT_EQ(honest[at], count) << at;
    for (std::uint8_t high : {0x7f, 0x80, 0xff}) {
      auto octets = honest;
      octets[at + 3] = high;
      EXPECT_THAT(code_of(deserialize<Everything>(octets)),
                  AnyOf(Code::truncated, Code::length_out_of_range))
          << at;
    }
  }
}

TEST(Cdr, LiesAnywhere_AllocateNoMoreThanTheTruth) {
  Bytes honest;
  serialize(everything(), honest);
  const auto allocated_by = [](BytesView octets) {
    const auto before = counted_memory::octets_ever();
    static_cast<void>(deserialize<Everything>(octets));
    return counted_memory::octets_ever() - before;
  };
  const auto truth = allocated_by(honest);
  EXPECT_GT(truth, 0);
  for (std::size_t at = 4; at + 4 <= honest.size(); at += 4)
    for (std::uint8_t high : {0x7f, 0x80, 0xff}) {
      auto octets = honest;
      octets[at + 3] = high;
      EXPECT_LE(allocated_by(octets), truth) << at;
    }
}

TEST(Cdr, Strings_EndWithTheirOnlyNul) {
  const auto with_text = [](Bytes text) {
    Bytes octets = {0, 1, 0, 0, static_cast<std::uint8_t>(text.size()), 0, 0, 0};
    octets.insert(octets.end(), text.begin(), text.end());
    octets.resize(octets.size() + 16);
    return deserialize<Shape>(octets);
  };
  EXPECT_EQ(code_of(with_text({'a', 'b', 'c', 'd'})), Code::malformed);
  EXPECT_EQ(code_of(with_text({'a', 0, 'c', 0})), Code::malformed);
  EXPECT_EQ(with_text({'a', 'b', 'c', 0})->color, "abc");
  EXPECT_EQ(with_text({})->color, "");
}

TEST(Cdr, ValuesBeyondTheirBounds_AreRefused) {
  Bytes out;
  serialize(Shape{std::string(129, 'x'), 0, 0, 0}, out);
  EXPECT_EQ(code_of(deserialize<Shape>(out)), Code::length_out_of_range);
  auto big = everything();
  big.octets.resize(101);
  serialize(big, out);
  EXPECT_EQ(code_of(deserialize<Everything>(out)), Code::length_out_of_range);
}

TEST(Cdr, ABoolean_IsZeroOrOne) {
  EXPECT_EQ(code_of(deserialize<Less>(Bytes{0, 1, 0, 0, 2, 0, 0, 0})), Code::malformed);
}

TEST(Cdr, DeepNesting_IsRefused) {
  Bytes octets = {0, 1, 0, 0};
  for (int i = 0; i < 100; ++i) octets.insert(octets.end(), {1, 0, 0, 0});
  octets.insert(octets.end(), {0, 0, 0, 0});
  EXPECT_EQ(code_of(deserialize<Tree>(octets)), Code::length_out_of_range);
}

}  // namespace
}  // namespace ddssec::rtps
