// Samples as they are written, in each encoding.
#include "rtps/cdr/cdr_writer.hpp"

#include "rtps/cdr/cdr_reader.hpp"
#include "tests/unit/rtps/cdr_types.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

TEST(Cdr, WrittenShape_IsWhatPeersWrite) {
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

TEST(Cdr, Xcdr2_AlignsToFourAndDelimitsAppendableTypes) {
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

TEST(Cdr, PaddingAtTheEnd_IsCounted) {
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

}  // namespace
}  // namespace ddssec::rtps
