#include "pki/crl_number.hpp"

#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

CrlNumber of(std::initializer_list<std::uint8_t> octets) {
  return CrlNumber::from_octets(Bytes(octets));
}

TEST(CrlNumber, LeadingZeros_DoNotCount) {
  EXPECT_EQ(of({0, 0, 1, 2}), CrlNumber(0x102));
  EXPECT_EQ(of({0, 0}), CrlNumber());
  EXPECT_EQ(to_string(of({0x01, 0x02})), "258");
  EXPECT_EQ(to_string(CrlNumber()), "0");
}

TEST(CrlNumber, NextNumber_IsOneMoreAtAnyLength) {
  EXPECT_EQ(CrlNumber(0).next(), CrlNumber(1));
  EXPECT_EQ(CrlNumber(0xff).next(), CrlNumber(0x100));
  EXPECT_EQ(CrlNumber(UINT64_MAX).next(), of({1, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(to_string(CrlNumber(UINT64_MAX).next()), "18446744073709551616");
  EXPECT_EQ(CrlNumber(UINT64_MAX).next().as_uint64(), std::nullopt);
  EXPECT_EQ(CrlNumber(UINT64_MAX).as_uint64(), UINT64_MAX);
}

TEST(CrlNumber, EachLength_IsComparedAsAWhole) {
  const auto large = CrlNumber::from_octets(Bytes(20, 0x7f));
  EXPECT_LT(CrlNumber(UINT64_MAX), large);
  EXPECT_LT(large, large.next());
  EXPECT_LT(CrlNumber(0x1ff), CrlNumber(0x200));
  EXPECT_LT(CrlNumber(), CrlNumber(1));
}

TEST(CrlNumber, LongerThanAnyCaMayMakeIt_IsNotWrittenOut) {
  EXPECT_EQ(to_string(CrlNumber::from_octets(Bytes(20, 1))).size(), 46u);
  EXPECT_EQ(to_string(CrlNumber::from_octets(Bytes(21, 1))),
            "of 21 octets, more than RFC 5280 allows");
}

}  // namespace
}  // namespace ddssec::pki
