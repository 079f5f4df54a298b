// The types that ddssec_idl_generate makes from rich.idl, compared octet for octet with Cyclone
// DDS's own serializer and Fast DDS's CDR.
#include "rich.hpp"

#include <cstring>

#include <gmock/gmock.h>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "tests/unit/rtps_idl/cyclone_serializer.h"
#include "tests/unit/rtps_idl/fast_cdr.hpp"

namespace ddssec::rtps {
namespace {

using namespace test_idl;
using parts::Color;

rich::Primitives primitives() {
  return {true,
          'c',
          200,
          -3,
          250,
          -300,
          60000,
          -70000,
          4000000000u,
          -5000000000,
          10000000000000000000u,
          1.5f,
          -2.25};
}

rich::Collections collections() {
  rich::Collections out;
  out.id = 42;
  out.bools = {true, false, true};
  out.octets = {1, 2, 3};
  out.shorts = {-1, 2, -3};
  out.doubles = {0.5};
  out.texts = {"", "one", "four"};
  out.labels = {"abcd", "e"};
  out.colors = {Color::BLUE, Color::RED, Color::GREEN};
  out.tinies = {rich::Tiny::TWO, rich::Tiny::ONE, rich::Tiny::TWO};
  out.smalls = {rich::Small::FAR};
  out.nested = {{1, 2}, {}, {3}};
  out.rows = {{1, 2, 3}, {4, 5, 6}};
  out.letters = {'a', 'b', 'c', 'd'};
  out.matrix = {{{1, 2, 3}, {4, 5, 6}}};
  out.table = {{{7, 8, 9}, {10, 11, 12}}};
  out.palette = {Color::GREEN, Color::BLUE};
  out.scale = {{{rich::Small::FAR, rich::Small::NEAR}, {rich::Small::FAR, rich::Small::FAR}}};
  out.names = {"left", "right"};
  out.codes = {"abc", ""};
  out.corners = {{{1, 2}, {3, 4}}};
  out.path = {{0.25, 0.75}};
  out.label = "12345678";
  return out;
}

rich::Nested nested() { return {{{1, "x"}, {2, "yz"}}, {{{5, "five"}, {6, ""}}}, true}; }

rich::Everything everything() {
  rich::Everything out;
  out.id = {3, 77, "note"};
  out.name = "eight";
  out.level = rich::Level::HIGH;
  out.primitives = primitives();
  out.collections = collections();
  out.nested = nested();
  out.tiny = rich::Tiny::TWO;
  out.class_ = "first";
  out.last = 9.75;
  return out;
}

// Our octets after Cyclone DDS read and wrote them, and its key hash for them.
struct Again {
  Bytes octets;
  KeyHash hash{};
};

Again cyclone(std::string_view type_name, XcdrVersion version, const Bytes& octets) {
  const auto* type = cyclone_type(std::string(type_name).c_str(), version == XcdrVersion::xcdr2);
  if (type == nullptr) return {};
  Again out{Bytes(octets.size() + 100)};
  out.octets.resize(cyclone_again(type, octets.data(), octets.size(), out.octets.data(),
                                  out.octets.size(), out.hash.data()));
  return out;
}

// Cyclone DDS 0.10 supports appendable types in XCDR2 only.
template <class T>
void expect_same(const T& value) {
  constexpr bool plain = TypeTraits<T>::extensibility == Extensibility::final_type;
  for (const auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
    if (version == XcdrVersion::xcdr1 && !plain) continue;
    SCOPED_TRACE(std::string(TypeTraits<T>::type_name) +
                 (version == XcdrVersion::xcdr1 ? " in XCDR1" : " in XCDR2"));
    Bytes octets, scratch;
    serialize(value, octets, version);
    const auto theirs = cyclone(TypeTraits<T>::type_name, version, octets);
    EXPECT_EQ(theirs.octets, octets);
    if (has_key<T>()) {
      EXPECT_EQ(theirs.hash, key_hash(value, scratch, false, version));
    }
    const auto read = deserialize<T>(octets);
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, value);
  }
}

TEST(Idl, EveryType_IsAsCycloneDdsWritesIt) {
  expect_same(primitives());
  expect_same(collections());
  expect_same(everything());
  expect_same(rich::Extended{-1, "text"});
  expect_same(nested());
}

TEST(Idl, EmptyOnes_AreAsCycloneDdsWritesThem) {
  expect_same(rich::Collections{});
  expect_same(rich::Everything{});
}

TEST(Idl, KeysOfEveryShape_HashAsInCycloneDds) {
  expect_same(rich::EnumKey{Color::BLUE, rich::Tiny::TWO, rich::Small::FAR, 1});
  expect_same(rich::ArrayKey{{{{1, 2}, {3, 4}}}, 2});
  expect_same(rich::PointKey{{1.5, 2.5}, 3});
  expect_same(rich::MixedKey{1, 2.5, 3, 4});
  expect_same(rich::inner::Id{1, 2, "three"});
}

static_assert(FlatType<rich::Frame> && FlatType<parts::Point> && FlatType<rich::ArrayKey>);
static_assert(!FlatType<rich::Primitives>);   // bool
static_assert(!FlatType<rich::inner::Id>);    // string
static_assert(!FlatType<rich::Collections>);  // sequences
static_assert(!FlatType<rich::Extended>);     // @appendable
static_assert(!FlatType<rich::PointKey>);     // padding at the end
static_assert(!FlatType<rich::EnumKey>);      // padding between members

// A loan is written as it is in memory.
TEST(Idl, FlatType_IsInMemoryAsCycloneDdsWritesIt) {
  rich::Frame frame{.number = 7,
                    .level = rich::Level::HIGH,
                    .origin = {1.5, -2.5},
                    .counts = {1, -2, 3, -4},
                    .grid = {{{1, 2, 3}, {4, 5, 6}}},
                    .tinies = {rich::Tiny::TWO, rich::Tiny::ONE, rich::Tiny::TWO},
                    .image = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
                    .small = rich::Small::FAR,
                    .corners = {{{1, 2}, {3, 4}}},
                    .last = -9};
  expect_same(frame);
  Bytes octets;
  serialize(frame, octets);
  ASSERT_EQ(octets.size(), kEncapsulationSize + sizeof frame);
  EXPECT_EQ(std::memcmp(octets.data() + kEncapsulationSize, &frame, sizeof frame), 0);
}

TEST(Idl, PrimitivesAndCollections_AreAsFastDdsWritesThem) {
  const auto p = primitives();
  Bytes ours;
  serialize(p, ours);
  EXPECT_EQ(fast_cdr([&](auto& cdr) {
              cdr << p.a_bool << p.a_char << p.an_octet << p.an_int8 << p.a_uint8 << p.a_short
                  << p.a_ushort << p.a_long << p.a_ulong << p.a_llong << p.a_ullong << p.a_float
                  << p.a_double;
            }),
            ours);
  const auto all = collections();
  rich::Collections c = all;
  serialize(c, ours);
  const auto small = [](auto e) { return static_cast<std::int16_t>(e); };
  EXPECT_EQ(fast_cdr([&](auto& cdr) {
              cdr << c.id << c.bools << c.octets << c.shorts << c.doubles << c.texts << c.labels;
              const auto enumerations = [&](const auto& values, auto as) {
                cdr << static_cast<std::uint32_t>(values.size());
                for (const auto value : values) cdr << static_cast<decltype(as)>(value);
              };
              enumerations(c.colors, std::uint32_t{});
              enumerations(c.tinies, std::int8_t{});
              enumerations(c.smalls, std::int16_t{});
              cdr << std::uint32_t{3};
              for (const auto& n : c.nested) cdr << n;
              cdr << std::uint32_t{2};
              for (const auto& r : c.rows) cdr << r;
              cdr << c.letters;
              for (const auto& m : c.matrix) cdr << m;
              for (const auto& t : c.table) cdr << t;
              for (const auto e : c.palette) cdr << static_cast<std::uint32_t>(e);
              for (const auto& row : c.scale)
                for (const auto e : row) cdr << small(e);
              cdr << c.names[0] << c.names[1] << c.codes[0] << c.codes[1];
              for (const auto& corner : c.corners) cdr << corner.x << corner.y;
              cdr << std::uint32_t{1} << c.path[0].x << c.path[0].y << c.label;
            }),
            ours);
}

TEST(Idl, TheHeader_SaysWhatTheFileSays) {
  EXPECT_EQ(TOP, 3);
  EXPECT_EQ(rich::GREETING, "h\"i");
  EXPECT_EQ(rich::LARGE, 18446744073709551615u);
  EXPECT_EQ(rich::SIZE, 4);
  const rich::Everything fresh;
  EXPECT_EQ(fresh.with_default, 5);
  EXPECT_TRUE(fresh.switched);
  EXPECT_EQ(fresh.level, rich::Level::LOW);
  EXPECT_EQ(EnumTraits<rich::Level>::labels[2].name, "HIGH");
  EXPECT_EQ(EnumTraits<rich::Level>::labels[2].value, 7);
  EXPECT_EQ(TypeTraits<rich::inner::Id>::type_name, "rich::inner::Id");
  std::vector<std::string_view> names;
  detail::for_each_member(fresh, [&](const auto& member) { names.push_back(member.name); });
  EXPECT_THAT(names,
              testing::ElementsAre("id", "name", "level", "primitives", "collections", "nested",
                                   "tiny", "with_default", "switched", "class", "last"));
}

// Every bound in the file is exceeded by one.
TEST(Idl, EachBoundExceeded_IsRefused) {
  const auto refuses = [](auto change) {
    auto value = collections();
    change(value);
    Bytes octets;
    serialize(value, octets);
    return !deserialize<rich::Collections>(octets);
  };
  EXPECT_FALSE(refuses([](auto&) {}));
  EXPECT_TRUE(refuses([](auto& c) { c.octets.resize(6); }));
  EXPECT_TRUE(refuses([](auto& c) { c.labels.resize(4); }));
  EXPECT_TRUE(refuses([](auto& c) { c.labels[0] = "abcde"; }));
  EXPECT_TRUE(refuses([](auto& c) { c.smalls.resize(4); }));
  EXPECT_TRUE(refuses([](auto& c) { c.codes[1] = "abcd"; }));
  EXPECT_TRUE(refuses([](auto& c) { c.path.resize(5); }));
  EXPECT_TRUE(refuses([](auto& c) { c.label += "9"; }));
}

TEST(Idl, CutAtAnyOctet_IsRefusedOrShorter) {
  for (const auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
    Bytes octets;
    serialize(collections(), octets, version);
    for (std::size_t size = 0; size + 4 < octets.size(); ++size)
      EXPECT_FALSE(deserialize<rich::Collections>(BytesView(octets).first(size))) << size;
  }
}

}  // namespace
}  // namespace ddssec::rtps
