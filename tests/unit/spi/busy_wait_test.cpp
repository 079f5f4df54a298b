#include "plugins/spi/busy_wait.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

using std::chrono::microseconds;

Result<std::optional<microseconds>> read_from(std::string value) {
  return busy_wait({{std::string(property::kBusyWait), std::move(value), false}});
}

TEST(BusyWait, MicrosecondsUpToAThousand_AreRead) {
  EXPECT_EQ(busy_wait({}).value(), std::nullopt);
  EXPECT_EQ(read_from("0").value(), microseconds(0));
  EXPECT_EQ(read_from("100").value(), microseconds(100));
  EXPECT_EQ(read_from("1000").value(), microseconds(1000));
}

TEST(BusyWait, AnythingElse_IsRefused) {
  for (const char* const bad : {"", "1001", "-1", "yes", "1ms", "99999999999999999999"}) {
    const auto refused = read_from(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, property::kBusyWait);
  }
}

}  // namespace
}  // namespace ddssec::spi
