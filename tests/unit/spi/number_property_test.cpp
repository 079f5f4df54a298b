// Properties with a number, and values that are computed from them.
#include "plugins/spi/number_property.hpp"

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

constexpr std::string_view kName = "org.ddssec.test";
constexpr NumberRange kRange{.unit = "seconds", .min = 5, .max = 20};

Result<std::uint64_t> number(std::string value) {
  return number_property({{std::string(kName), std::move(value), false}}, kName, kRange, 7);
}

TEST(NumberProperty, MissingProperty_HasTheOtherValue) {
  EXPECT_EQ(number_property({}, kName, kRange, 7), 7u);
  EXPECT_EQ(number_property({{"org.ddssec.other", "9", false}}, kName, kRange, 7), 7u);
}

TEST(NumberProperty, Range_IncludesBothEndsAndZero) {
  EXPECT_EQ(number("5"), 5u);
  EXPECT_EQ(number("20"), 20u);
  EXPECT_EQ(number("0"), 0u);
}

TEST(NumberProperty, AnythingElse_IsRefusedWithTheRange) {
  for (const char* const bad : {"", "4", "21", "-5", "+5", " 5", "5 ", "5s", "0x5", "5.0",
                                "18446744073709551616", "18446744073709551621"}) {
    const auto refused = number(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, kName);
    EXPECT_EQ(refused.error().details().expected, "seconds from 5 to 20, or 0");
    EXPECT_EQ(refused.error().details().found, bad);
  }
}

TEST(NumberProperty, LongValue_IsCutInTheError) {
  EXPECT_EQ(number(std::string(1000, '9')).error().details().found, std::string(64, '9'));
}

}  // namespace
}  // namespace ddssec::spi
