#include "plugins/spi/flag_property.hpp"

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

constexpr std::string_view kName = "org.ddssec.test";

Result<bool> flag(std::string value) { return flag_property({{std::string(kName), value}}, kName); }

TEST(FlagProperty, FlagWithoutAValue_IsFalse) {
  EXPECT_EQ(flag_property({}, kName), false);
  EXPECT_EQ(flag("false"), false);
  EXPECT_EQ(flag("true"), true);
}

TEST(FlagProperty, OtherWords_AreRefused) {
  for (const char* const bad : {"", "yes", "1", "True", "true "}) {
    const auto refused = flag(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, kName);
  }
}

}  // namespace
}  // namespace ddssec::spi
