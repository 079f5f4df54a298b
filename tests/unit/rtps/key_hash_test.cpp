// Key hashes.
#include "rtps/cdr/key_hash.hpp"

#include "rtps/cdr/cdr_reader.hpp"
#include "tests/unit/rtps/cdr_types.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

TEST(KeyHash, ShortKeys_StandForThemselvesAndLongOnesAreHashed) {
  Bytes scratch;
  EXPECT_EQ(to_hex(key_hash(Point{0x01020304, 9}, scratch)), "01020304000000000000000000000000");
  // The MD5 digest of 00000005 "BLUE" 00.
  const Bytes key = {0, 0, 0, 5, 'B', 'L', 'U', 'E', 0};
  EXPECT_EQ(key_hash(Shape{"BLUE", 1, 2, 3}, scratch), md5(key));
  EXPECT_EQ(key_hash(Point{1, 9}, scratch, true), md5(Bytes{0, 0, 0, 1}));
  EXPECT_TRUE(has_key<Shape>());
  EXPECT_FALSE(has_key<Inner>());
}

}  // namespace
}  // namespace ddssec::rtps
