#include "governance/doctor/product.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

TEST(Product, IdWithOrWithoutVersion_IsFound) {
  for (const auto product : kProducts) EXPECT_EQ(product_from(id(product)), product);
  EXPECT_EQ(product_from("ddssec"), Product::ddssec);
  EXPECT_EQ(product_from("ours"), Product::ddssec);
  EXPECT_EQ(named_product_from("cyclonedds"), NamedProduct{Product::cyclonedds});
  EXPECT_EQ(named_product_from("fastdds@3.1"), (NamedProduct{Product::fastdds, Version{3, 1, 0}}));
  EXPECT_EQ(id(Product::fastdds, {.fastdds = {3, 1, 2}}), "fastdds@3.1.2");
  for (const auto* other :
       {"", "cyclone", "fastdds@", "OURS", "ddssec@1.0.0", "ours@1.0.0", "fastdds@-1",
        "fastdds@1..2", "fastdds@1.2.3.4", "fastdds@1.2x", "fastdds@99999"})
    EXPECT_EQ(named_product_from(other), std::nullopt) << other;
}

TEST(Outcomes, SeveralOutcomes_TheWorseCountsForEachProduct) {
  constexpr Outcomes a{.cyclonedds = Outcome::late, .ddssec = Outcome::unsafe};
  constexpr Outcomes b{
      .cyclonedds = Outcome::ok, .fastdds = Outcome::fail, .ddssec = Outcome::late};
  EXPECT_EQ(a.worse(b), (Outcomes{Outcome::late, Outcome::fail, Outcome::late}));
  EXPECT_EQ(b.worse(a), a.worse(b));
  EXPECT_FALSE(a.all_ok());
  EXPECT_TRUE(Outcomes{}.all_ok());
  EXPECT_EQ(Outcomes::all(Outcome::fail).of(Product::fastdds), Outcome::fail);
  EXPECT_EQ(b.of(Product::cyclonedds), Outcome::ok);
}

TEST(Outcome, EachOutcome_HasAWord) {
  EXPECT_EQ(to_string(Outcome::ok), "ok");
  EXPECT_EQ(to_string(Outcome::unsafe), "unsafe");
  EXPECT_EQ(to_string(Outcome::late), "late");
  EXPECT_EQ(to_string(Outcome::fail), "fail");
  EXPECT_EQ(name(Product::fastdds), "Fast DDS 2.9.1");
}

}  // namespace
}  // namespace ddssec::governance::doctor
