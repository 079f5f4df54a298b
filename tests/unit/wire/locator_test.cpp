// The forms of a locator.
#include "wire/locator.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/entity_ids.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

TEST(Locator, EachAddress_TellsItsNature) {
  EXPECT_EQ(to_string(*Locator::parse("127.0.0.1", 7400)), "udp/127.0.0.1:7400");
  EXPECT_EQ(to_string(*Locator::parse("::1", 7400)), "udp/[::1]:7400");
  EXPECT_EQ(to_string(Locator{LocatorKind{16}, 1, {}}), "kind 16");
  EXPECT_TRUE(Locator::parse("239.255.0.1", 1)->is_multicast());
  EXPECT_TRUE(Locator::parse("ff02::1", 1)->is_multicast());
  EXPECT_TRUE(Locator::parse("::1", 1)->is_loopback());
  EXPECT_FALSE(Locator::parse("::2", 1)->is_loopback());
  EXPECT_FALSE(Locator::parse("0.0.0.0", 1)->is_usable());
  EXPECT_FALSE(Locator::parse("10.0.0.1", 0)->is_usable());
  EXPECT_FALSE(Locator::parse("::", 1)->is_usable());
  EXPECT_FALSE(Locator::parse("::ffff:0.0.0.0", 1)->is_usable());
  auto disguised = *Locator::parse("0.0.0.0", 1);
  disguised.address[3] = 1;
  EXPECT_FALSE(disguised.is_usable());
  EXPECT_TRUE(Locator::parse("::ffff:127.0.0.1", 1)->is_loopback());
  EXPECT_TRUE(Locator::parse("::ffff:239.255.0.1", 1)->is_multicast());
  EXPECT_FALSE(Locator::parse("localhost", 1));
  Locator out_of_range = *Locator::parse("10.0.0.1", 1);
  out_of_range.port = 0x10000;
  EXPECT_FALSE(out_of_range.is_usable());
}

}  // namespace
}  // namespace ddssec::rtps
