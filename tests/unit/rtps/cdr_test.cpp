#include <optional>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {

enum class Colour : std::int32_t { red, green };

struct Shape {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
  bool operator==(const Shape&) const = default;
};
template <>
struct TypeTraits<Shape> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.color, 128), s.x, s.y, s.shapesize);
  }
};

struct Inner {
  std::uint8_t octet = 0;
  std::uint64_t wide = 0;
  bool operator==(const Inner&) const = default;
};
template <>
struct TypeTraits<Inner> {
  static constexpr std::string_view type_name = "Inner";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.octet, s.wide);
  }
};

struct Everything {
  bool flag = false;
  std::int16_t small = 0;
  double real = 0;
  float single = 0;
  Colour colour = Colour::red;
  std::array<std::uint16_t, 3> fixed{};
  std::vector<std::uint8_t> octets;
  std::vector<std::int64_t> wide;
  std::vector<std::string> texts;
  std::vector<Inner> inners;
  Inner last;
  bool operator==(const Everything&) const = default;
};
template <>
struct TypeTraits<Everything> {
  static constexpr std::string_view type_name = "Everything";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.flag, s.small, s.real, s.single, s.colour, s.fixed, bounded(s.octets, 100), s.wide,
          s.texts, s.inners, s.last);
  }
};

// The first version of Everything.
struct Less {
  bool flag = false;
  std::int16_t small = 0;
  bool operator==(const Less&) const = default;
};
template <>
struct TypeTraits<Less> {
  static constexpr std::string_view type_name = "Everything";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.flag, s.small);
  }
};

struct Point {
  std::int32_t id = 0;
  std::int64_t line = 0;
};
template <>
struct TypeTraits<Point> {
  static constexpr std::string_view type_name = "Point";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.id), s.line);
  }
};

struct Tree {
  std::vector<Tree> children;
};
template <>
struct TypeTraits<Tree> {
  static constexpr std::string_view type_name = "Tree";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.children);
  }
};

namespace {

using testing::code_of;

Everything everything() {
  return {true,      -2,     2.5,     0.5f,      Colour::green,
          {1, 2, 3}, {7, 8}, {-1, 1}, {"a", ""}, {{1, 2}, {3, 4}},
          {5, 6}};
}

TEST(Cdr, ShapeIsWhatPeersWrite) {
  Bytes out;
  serialize(Shape{"BLUE", 1, 2, 30}, out);
  EXPECT_EQ(to_hex(out),
            "00010000"
            "05000000"
            "424c554500"
            "000000"
            "01000000"
            "02000000"
            "1e000000");
  serialize(Shape{"BLUE", 1, 2, 30}, out, XcdrVersion::xcdr2, Endian::big);
  EXPECT_EQ(to_hex(out),
            "00060000"
            "00000005"
            "424c554500"
            "000000"
            "00000001"
            "00000002"
            "0000001e");
}

TEST(Cdr, Xcdr2AlignsToFourAndDelimitsAppendableTypes) {
  Bytes out;
  serialize(Inner{1, 2}, out, XcdrVersion::xcdr2);
  EXPECT_EQ(to_hex(out),
            "00090000"
            "0c000000"
            "01"
            "000000"
            "0200000000000000");
  serialize(Inner{1, 2}, out, XcdrVersion::xcdr1);
  EXPECT_EQ(to_hex(out),
            "00010000"
            "01"
            "00000000000000"
            "0200000000000000");
}

TEST(Cdr, PaddingAtTheEndIsCounted) {
  Bytes out;
  serialize(Less{true, 5}, out);
  EXPECT_EQ(to_hex(out),
            "00010000"
            "01000500");
  serialize_key(Shape{"BLUE", 0, 0, 0}, out);
  EXPECT_EQ(to_hex(out),
            "00010003"
            "05000000"
            "424c554500"
            "000000");
}

TEST(Cdr, RoundTripsInEveryEncoding) {
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

TEST(Cdr, EveryTruncationIsRefusedOrAnOlderVersion) {
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

TEST(Cdr, AppendableTypesReadOlderAndNewerWriters) {
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

// CVE-2020-18735, CVE-2023-23932 and the sequences of CVE-2026-45097 and -49861: claims of 2^31
// elements.
TEST(Cdr, LyingCountsAllocateNothing) {
  Bytes honest;
  serialize(everything(), honest);
  for (std::size_t at = 4; at + 4 <= honest.size(); at += 4) {
    for (std::uint8_t high : {0x7f, 0x80, 0xff}) {
      auto octets = honest;
      octets[at + 3] = high;
      const auto read = deserialize<Everything>(octets);
      EXPECT_LE(read ? read->octets.size() + read->wide.size() : 0, honest.size());
    }
  }
}

TEST(Cdr, StringsEndWithTheirOnlyNul) {
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

TEST(Cdr, BoundsAreKept) {
  Bytes out;
  serialize(Shape{std::string(129, 'x'), 0, 0, 0}, out);
  EXPECT_EQ(code_of(deserialize<Shape>(out)), Code::length_out_of_range);
  auto big = everything();
  big.octets.resize(101);
  serialize(big, out);
  EXPECT_EQ(code_of(deserialize<Everything>(out)), Code::length_out_of_range);
}

TEST(Cdr, ABooleanIsZeroOrOne) {
  EXPECT_EQ(code_of(deserialize<Less>(Bytes{0, 1, 0, 0, 2, 0, 0, 0})), Code::malformed);
}

TEST(Cdr, OtherEncapsulationsAreRefused) {
  for (std::uint8_t id : {0x04, 0x05, 0x0c, 0x20, 0xff})
    EXPECT_EQ(code_of(open_payload(Bytes{0, id, 0, 0})), Code::rtps_encapsulation_unsupported);
  for (std::uint8_t id : {0x02, 0x03, 0x08, 0x0a})
    EXPECT_EQ(code_of(deserialize<Shape>(Bytes{0, id, 0, 0})),
              Code::rtps_encapsulation_unsupported);
  EXPECT_EQ(code_of(open_payload(Bytes{0, 1, 0, 3, 1, 2})), Code::truncated);
  EXPECT_EQ(code_of(open_payload(Bytes{0, 1, 0})), Code::truncated);
}

TEST(Cdr, DeepNestingIsRefused) {
  Bytes octets = {0, 1, 0, 0};
  for (int i = 0; i < 100; ++i) octets.insert(octets.end(), {1, 0, 0, 0});
  octets.insert(octets.end(), {0, 0, 0, 0});
  EXPECT_EQ(code_of(deserialize<Tree>(octets)), Code::length_out_of_range);
}

TEST(KeyHash, ShortKeysStandForThemselvesLongOnesAreHashed) {
  Bytes scratch;
  EXPECT_EQ(to_hex(key_hash(Point{0x01020304, 9}, scratch)), "01020304000000000000000000000000");
  // MD5 of 00000005 "BLUE" 00.
  const Bytes key = {0, 0, 0, 5, 'B', 'L', 'U', 'E', 0};
  EXPECT_EQ(key_hash(Shape{"BLUE", 1, 2, 3}, scratch), md5(key));
  EXPECT_EQ(key_hash(Point{1, 9}, scratch, true), md5(Bytes{0, 0, 0, 1}));
  EXPECT_TRUE(has_key<Shape>());
  EXPECT_FALSE(has_key<Inner>());
}

}  // namespace
}  // namespace ddssec::rtps
