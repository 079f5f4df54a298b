#include "plugins/spi/shared_memory.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"
#include "tests/support/expect_code.hpp"

namespace ddssec::spi {
namespace {

PropertyList with(std::string_view name, std::string value) {
  return {{std::string(name), std::move(value)}};
}

TEST(SharedMemoryProperties, MemoryWithoutProperties_IsOff) {
  EXPECT_EQ(shared_memory({}), SharedMemory{});
  EXPECT_EQ(shared_memory(with(property::kSharedMemory, "off")), SharedMemory{});
  EXPECT_EQ(shared_memory(with(property::kSharedMemory, "on")), (SharedMemory{true, false}));
  EXPECT_EQ(shared_memory(with(property::kTrustKernel, "true")), (SharedMemory{false, true}));
  EXPECT_EQ(shared_memory(with(property::kSharedWithOtherUsers, "true")),
            (SharedMemory{.with_other_users = true}));
}

TEST(SharedMemoryProperties, AnythingElse_Refused) {
  for (const char* const bad : {"", "yes", "true", "On", "on "}) {
    const auto refused = shared_memory(with(property::kSharedMemory, bad));
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
    EXPECT_EQ(refused.error().details().document, property::kSharedMemory);
  }
  EXPECT_CODE(shared_memory(with(property::kTrustKernel, "on")), invalid_property);
  EXPECT_CODE(shared_memory(with(property::kSharedWithOtherUsers, "all")), invalid_property);
}

TEST(SharedMemoryProperties, MostOctets_IsANumber) {
  EXPECT_EQ(shared_memory({})->max_octets, std::size_t{256} << 20);
  EXPECT_EQ(shared_memory(with(property::kMaxSharedOctets, "1000000"))->max_octets, 1'000'000u);
  for (const char* const bad : {"", "-1", "1M", "1099511627777"}) {
    const auto refused = shared_memory(with(property::kMaxSharedOctets, bad));
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), Code::invalid_property);
  }
}

}  // namespace
}  // namespace ddssec::spi
