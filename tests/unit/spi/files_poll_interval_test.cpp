#include "plugins/spi/files_poll_interval.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

Result<std::chrono::seconds> interval(std::string value) {
  return files_poll_interval({{std::string(property::kFilesPollInterval), std::move(value)}});
}

TEST(FilesPollInterval, SecondsUpToTheBound_AreRead) {
  EXPECT_EQ(files_poll_interval({}), kDefaultFilesPollInterval);
  // `ddssec identity revoke` promises that a list counts within two seconds.
  EXPECT_LE(kDefaultFilesPollInterval, std::chrono::seconds(1));
  EXPECT_EQ(interval("0"), std::chrono::seconds(0));
  EXPECT_EQ(interval("90"), std::chrono::seconds(90));
  EXPECT_EQ(interval("86400"), kMaxFilesPollInterval);
}

TEST(FilesPollInterval, OtherThanSeconds_IsRefused) {
  for (const auto* const bad :
       {"", "-1", "5s", " 5", "1.5", "86401", "4294967296", "99999999999999999999"}) {
    const auto refused = interval(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, property::kFilesPollInterval);
  }
}

}  // namespace
}  // namespace ddssec::spi
