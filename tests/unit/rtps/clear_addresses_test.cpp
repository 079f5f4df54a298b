#include "rtps/participant/clear_addresses.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

Locator at(std::size_t port) {
  return Locator::udp_v4({192, 0, 2, 1}, static_cast<std::uint16_t>(port));
}
EntityId reader(std::uint8_t number) { return {{0, 0, number, 7}}; }

TEST(ClearAddressesTest, FurtherAddresses_AreRefused_AndKnownOnesAreNot) {
  ClearAddresses addresses;
  for (std::size_t i = 0; i < ClearAddresses::kMax; ++i)
    EXPECT_TRUE(addresses.use(at(i), reader(1)));
  EXPECT_FALSE(addresses.use(at(1000), reader(1)));
  EXPECT_TRUE(addresses.use(at(0), reader(2)));
}

TEST(ClearAddressesTest, Address_StaysUntilItsLastEndpointHasEnded) {
  ClearAddresses addresses;
  for (std::size_t i = 0; i < ClearAddresses::kMax; ++i) addresses.use(at(i), reader(1));
  addresses.use(at(0), reader(2));
  addresses.release(reader(1));
  for (std::size_t i = 1; i < ClearAddresses::kMax; ++i)
    EXPECT_TRUE(addresses.use(at(1000 + i), reader(3)));
  EXPECT_FALSE(addresses.use(at(1), reader(3)));
  EXPECT_TRUE(addresses.use(at(0), reader(3)));
  addresses.clear();
  EXPECT_TRUE(addresses.use(at(1), reader(3)));
}

}  // namespace
}  // namespace ddssec::rtps
