#include "governance/byte_classes.hpp"

#include <set>

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

std::bitset<256> octets(std::string_view text) {
  std::bitset<256> out;
  for (const char c : text) out.set(static_cast<std::uint8_t>(c));
  return out;
}

TEST(ByteClasses, OctetsThatNoSetTellsApart_AreOneClass) {
  ByteClasses classes;
  classes.number();
  EXPECT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes.of('a'), classes.of(0xff));
  EXPECT_EQ(classes.shown(0), 'a');
}

TEST(ByteClasses, SetsThatOverlap_MakeAClassOfEachPart) {
  ByteClasses classes;
  classes.separate(octets("abc"));
  classes.separate(octets("bcd"));
  classes.number();
  EXPECT_EQ(classes.size(), 4u);
  EXPECT_EQ(classes.of('b'), classes.of('c'));
  const std::set<ByteClasses::Class> parts = {classes.of('a'), classes.of('b'), classes.of('d'),
                                              classes.of('x')};
  EXPECT_EQ(parts.size(), 4u);
}

TEST(ByteClasses, SingleOctet_IsAloneInItsClass) {
  ByteClasses classes;
  classes.separate(std::uint8_t{'q'});
  classes.number();
  EXPECT_EQ(classes.size(), 2u);
  EXPECT_EQ(classes.shown(classes.of('q')), 'q');
  EXPECT_EQ(classes.shown(classes.of('r')), 'a');
}

// No name contains a NUL.
TEST(ByteClasses, NulAlone_HasNoClass) {
  ByteClasses classes;
  classes.separate(std::uint8_t{0});
  classes.number();
  EXPECT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes.of(0), ByteClasses::kNone);
}

TEST(ByteClasses, ReadableOctets_ComeFirst) {
  ByteClasses classes;
  classes.separate(octets("\x01\x02"));
  classes.separate(octets("~"));
  classes.number();
  EXPECT_EQ(classes.shown(0), 'a');
  EXPECT_EQ(classes.shown(1), '~');
  EXPECT_EQ(classes.shown(2), '\x01');
}

TEST(ByteClasses, EveryOctetInAClassOfItsOwn_IsPossible) {
  ByteClasses classes;
  for (int octet = 0; octet < 256; ++octet) classes.separate(static_cast<std::uint8_t>(octet));
  classes.number();
  EXPECT_EQ(classes.size(), 255u);
  for (int octet = 1; octet < 256; ++octet) {
    const auto one = static_cast<std::uint8_t>(octet);
    EXPECT_EQ(static_cast<std::uint8_t>(classes.shown(classes.of(one))), one);
  }
}

TEST(OctetsByReadability, EachOctetButNul_ComesOnce) {
  const auto& order = octets_by_readability();
  EXPECT_EQ(order.size(), 255u);
  EXPECT_EQ(std::set<char>(order.begin(), order.end()).size(), 255u);
  EXPECT_EQ(order.find('\0'), order.npos);
}

}  // namespace
}  // namespace ddssec::governance
