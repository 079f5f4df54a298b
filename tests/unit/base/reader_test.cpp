// Reading octets of peers and files.
#include "base/reader.hpp"

#include <gtest/gtest.h>

#include "base/writer.hpp"

namespace ddssec {
namespace {

TEST(Cursor, WrittenValues_ReadBackInBothByteOrders) {
  for (auto endian : {Endian::big, Endian::little}) {
    Writer writer(endian);
    writer.write<std::uint8_t>(7);
    writer.write_aligned<std::uint32_t>(0x01020304);
    writer.write_string("abc");
    writer.write_octet_sequence(as_bytes("xy"));
    writer.write_aligned<std::int64_t>(-5);
    const auto octets = writer.take();

    Reader reader(octets, endian);
    EXPECT_EQ(reader.read<std::uint8_t>(), 7);
    EXPECT_EQ(reader.read_aligned<std::uint32_t>(), 0x01020304u);
    EXPECT_EQ(reader.read_string(), "abc");
    EXPECT_EQ(as_text(reader.read_octet_sequence().value()), "xy");
    EXPECT_EQ(reader.read_aligned<std::int64_t>(), -5);
    EXPECT_TRUE(reader.finish());
  }
}

TEST(Cursor, EveryTruncation_FailsAndMovesNothing) {
  Writer writer;
  writer.write_string("hello");
  const auto octets = writer.take();
  for (std::size_t size = 0; size < octets.size(); ++size) {
    Reader reader(BytesView(octets).first(size));
    const auto text = reader.read_string();
    ASSERT_FALSE(text) << size;
    EXPECT_EQ(text.error().code(), Code::truncated);
    EXPECT_EQ(reader.position(), 0u);
  }
}

// The first octet is read, so that each read below skips three octets of padding first.
TEST(Cursor, TruncationAfterPadding_MovesNothing) {
  Writer writer;
  writer.write<std::uint8_t>(7);
  writer.write_string("hello");
  const auto octets = writer.take();
  const auto expect_unmoved = [&](std::size_t size, const auto& read) {
    Reader reader(BytesView(octets).first(size));
    ASSERT_TRUE(reader.read<std::uint8_t>());
    const auto result = read(reader);
    ASSERT_FALSE(result) << size;
    EXPECT_EQ(result.error().code(), Code::truncated) << size;
    EXPECT_EQ(reader.position(), 1u) << size;
  };
  for (std::size_t size = 1; size < octets.size(); ++size) {
    expect_unmoved(size, [](Reader& r) { return r.read_string(); });
    expect_unmoved(size, [](Reader& r) { return r.read_octet_sequence(); });
  }
  for (std::size_t size = 1; size < 8; ++size) {
    expect_unmoved(size, [](Reader& r) { return r.read_aligned<std::uint32_t>(); });
    expect_unmoved(size, [](Reader& r) { return r.read_count(1); });
    expect_unmoved(size, [](Reader& r) { return r.align(8); });
  }
}

TEST(Cursor, CountBeyondTheDataAfterPadding_MovesNothing) {
  const Bytes octets = {7, 0, 0, 0, 0, 0, 0, 9, 1};
  Reader reader(octets);
  ASSERT_TRUE(reader.read<std::uint8_t>());
  EXPECT_EQ(reader.read_count(1).error().code(), Code::length_out_of_range);
  EXPECT_EQ(reader.position(), 1u);
}

TEST(Cursor, CountBeyondTheData_IsRefused) {
  for (std::uint32_t lie : {3u, 0x80000000u, 0xffffffffu}) {
    Writer writer;
    writer.write(lie);
    writer.write<std::uint64_t>(0);
    const auto octets = writer.take();
    Reader reader(octets);
    const auto count = reader.read_count(4);
    ASSERT_FALSE(count);
    EXPECT_EQ(count.error().code(), Code::length_out_of_range);
    EXPECT_EQ(reader.position(), 0u);
  }
}

TEST(Cursor, StringsWithInnerOrMissingNul_AreRefused) {
  for (const char* hex : {"0000000361006200", "000000026162", "00000003610000"}) {
    const auto octets = from_hex(hex).value();
    EXPECT_EQ(Reader(octets).read_string().error().code(), Code::malformed) << hex;
  }
}

TEST(Cursor, TrailingOctets_AreReported) {
  const Bytes octets = {1, 2};
  Reader reader(octets);
  EXPECT_TRUE(reader.read<std::uint8_t>());
  EXPECT_EQ(reader.finish().error().code(), Code::trailing_octets);
}

TEST(Cursor, ReadIntoAFixedSize_IsAllOrNothing) {
  const Bytes octets = {1, 2, 3};
  Reader reader(octets);
  Bytes two(2), many(2);
  EXPECT_TRUE(reader.read_into(two));
  EXPECT_EQ(two, (Bytes{1, 2}));
  EXPECT_EQ(reader.read_into(many).error().code(), Code::truncated);
  EXPECT_EQ(many, Bytes(2)) << "written although the octets do not suffice";
  EXPECT_EQ(reader.position(), 2u);
}

TEST(Cursor, AlignmentThatLeavesTheOctets_FailsAndMovesNothing) {
  const Bytes octets = {1, 2, 3};
  Reader reader(octets);
  EXPECT_TRUE(reader.align(4)) << "aligned already";
  EXPECT_TRUE(reader.skip(1));
  EXPECT_EQ(reader.align(4).error().code(), Code::truncated);
  EXPECT_EQ(reader.skip(3).error().code(), Code::truncated);
  EXPECT_EQ(reader.position(), 1u);
  EXPECT_TRUE(reader.align(2));
  EXPECT_EQ(reader.position(), 2u);
}

// Some peers send such strings.
TEST(Cursor, StringOfLengthZero_IsEmpty) {
  const auto octets = from_hex("00000000").value();
  EXPECT_EQ(Reader(octets).read_string(), "");
}

}  // namespace
}  // namespace ddssec
