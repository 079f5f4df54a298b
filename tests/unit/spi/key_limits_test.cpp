#include "plugins/spi/key_limits.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

Result<KeyLimits> limits(std::string_view name, std::string value) {
  return key_limits({{std::string(name), std::move(value)}});
}

TEST(KeyLimitsProperties, UnsetOrZeroProperties_GiveNoLimits) {
  EXPECT_FALSE(key_limits({})->any());
  EXPECT_FALSE(limits(property::kKeyLifetime, "0")->any());
  EXPECT_FALSE(limits(property::kMaxBlocksPerKey, "0")->any());
}

TEST(KeyLimitsProperties, SecondsAndBlocks_AreRead) {
  EXPECT_EQ(limits(property::kKeyLifetime, "20")->lifetime, kMinKeyLifetime);
  EXPECT_EQ(limits(property::kKeyLifetime, "31536000")->lifetime, kMaxKeyLifetime);
  EXPECT_EQ(limits(property::kMaxBlocksPerKey, "1")->blocks, 1u);
  EXPECT_EQ(limits(property::kMaxBlocksPerKey, "18446744073709551615")->blocks, ~std::uint64_t{0});
  EXPECT_TRUE(limits(property::kKeyLifetime, "3600")->any());
  EXPECT_TRUE(limits(property::kMaxBlocksPerKey, "1")->any());
}

TEST(KeyLimitsProperties, OtherValues_AreRefused) {
  const auto expect_refused = [](std::string_view name, const std::string& value) {
    const auto refused = limits(name, value);
    ASSERT_FALSE(refused) << name << " " << value;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, name);
    EXPECT_EQ(refused.error().details().found, value.substr(0, 64));
  };
  for (const auto name : {property::kKeyLifetime, property::kMaxBlocksPerKey})
    for (const auto& bad : {std::string(), std::string("-1"), std::string("1h"), std::string(" 90"),
                            std::string("1.5"), std::string("18446744073709551616"),
                            std::string("0x20"), std::string(200, '9')})
      expect_refused(name, bad);
  for (const auto* const bad : {"1", "19", "31536001", "18446744073709551615"})
    expect_refused(property::kKeyLifetime, bad);
}

}  // namespace
}  // namespace ddssec::spi
