#include "governance/doctor/product.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

TEST(Vendor, IdWithOrWithoutVersion_IsFound) {
  for (const auto vendor : kVendors) EXPECT_EQ(vendor_from(id(vendor)), vendor);
  EXPECT_EQ(vendor_from("ddssec"), Vendor::ddssec);
  EXPECT_EQ(vendor_from("ours"), Vendor::ddssec);
  EXPECT_EQ(product_from("cyclonedds"), NamedProduct{Vendor::cyclonedds});
  EXPECT_EQ(product_from("fastdds@3.1"), (NamedProduct{Vendor::fastdds, Version{3, 1, 0}}));
  EXPECT_EQ(id(Vendor::fastdds, {.fastdds = {3, 1, 2}}), "fastdds@3.1.2");
  for (const auto* other :
       {"", "cyclone", "fastdds@", "OURS", "ddssec@1.0.0", "ours@1.0.0", "fastdds@-1",
        "fastdds@1..2", "fastdds@1.2.3.4", "fastdds@1.2x", "fastdds@99999"})
    EXPECT_EQ(product_from(other), std::nullopt) << other;
}

TEST(Outcomes, SeveralOutcomes_TheWorseCountsForEachProduct) {
  constexpr Outcomes a{.cyclonedds = Outcome::late, .ddssec = Outcome::unsafe};
  constexpr Outcomes b{
      .cyclonedds = Outcome::ok, .fastdds = Outcome::fail, .ddssec = Outcome::late};
  EXPECT_EQ(a.worse(b), (Outcomes{Outcome::late, Outcome::fail, Outcome::late}));
  EXPECT_EQ(b.worse(a), a.worse(b));
  EXPECT_FALSE(a.all_ok());
  EXPECT_TRUE(Outcomes{}.all_ok());
  EXPECT_EQ(Outcomes::all(Outcome::fail).of(Vendor::fastdds), Outcome::fail);
  EXPECT_EQ(b.of(Vendor::cyclonedds), Outcome::ok);
}

TEST(Outcome, EachOutcome_HasAWord) {
  EXPECT_EQ(to_string(Outcome::ok), "ok");
  EXPECT_EQ(to_string(Outcome::unsafe), "unsafe");
  EXPECT_EQ(to_string(Outcome::late), "late");
  EXPECT_EQ(to_string(Outcome::fail), "fail");
  EXPECT_EQ(name(Vendor::fastdds), "Fast DDS 2.9.1");
}

}  // namespace
}  // namespace ddssec::governance::doctor
