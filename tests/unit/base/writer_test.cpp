// Writing octets.
#include "base/writer.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Cursor, BigEndianCdr_IsAsTheSpecificationPrintsIt) {
  Writer writer;
  writer.write_string("A");
  writer.write_octet_sequence(as_bytes("BC"));
  EXPECT_EQ(to_hex(writer.view()),
            "00000002410000000000000242"
            "43");
}

TEST(Cursor, Alignment_IsWrittenAsZeros) {
  Writer writer;
  writer.write<std::uint8_t>(1);
  writer.write_aligned<std::uint16_t>(2);
  writer.align(8);
  EXPECT_EQ(to_hex(writer.view()), "0100000200000000");
  EXPECT_EQ(writer.size(), 8u);
  EXPECT_EQ(writer.take().size(), 8u);
  EXPECT_EQ(writer.size(), 0u);
}

}  // namespace
}  // namespace ddssec
