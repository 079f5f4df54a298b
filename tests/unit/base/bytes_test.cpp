#include "base/bytes.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Hex, OtherCharacters_AreRefused) {
  EXPECT_EQ(from_hex("0g"), std::nullopt);
  EXPECT_EQ(from_hex("abc"), std::nullopt);
  EXPECT_EQ(from_hex("aBcD"), (Bytes{0xab, 0xcd}));
}

TEST(Hex, Octets_AreTwoLowerCaseDigitsEach) {
  EXPECT_EQ(to_hex(Bytes{0x00, 0x0f, 0xa0, 0xff}), "000fa0ff");
  EXPECT_EQ(to_hex({}), "");
  EXPECT_EQ(from_hex(""), Bytes());
}

TEST(Text, Views_HoldEveryOctet) {
  const std::string_view text("a\0\xff", 3);
  EXPECT_EQ(to_bytes(as_bytes(text)), (Bytes{'a', 0, 0xff}));
  EXPECT_EQ(as_text(as_bytes(text)), text);
}

}  // namespace
}  // namespace ddssec
