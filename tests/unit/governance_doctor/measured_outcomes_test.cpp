// The measured behaviour of each version.
#include "governance/doctor/measured_outcomes.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {
namespace {

TEST(MeasuredOutcomes, TheNearestOlderVersion_StandsForOneThatWasNotMeasured) {
  const auto cyclone = [](Version version) {
    return stand_in(Product::cyclonedds, version).version;
  };
  EXPECT_EQ(cyclone({0, 10, 2}), (Version{0, 10, 2}));
  EXPECT_EQ(cyclone({0, 10, 4}), (Version{0, 10, 2}));
  EXPECT_EQ(cyclone({0, 11, 0}), (Version{0, 10, 5}));
  EXPECT_EQ(cyclone({12, 0, 0}), (Version{11, 0, 0}));
  EXPECT_EQ(cyclone({0, 9, 0}), (Version{0, 10, 2}));  // the oldest measured version
  EXPECT_EQ(stand_in(Product::cyclonedds, {11, 0, 1}).source, Source::reported);
  EXPECT_EQ(stand_in(Product::fastdds, {4, 0, 0}), (KnownVersion{{3, 1, 2}, Source::measured}));
}

TEST(MeasuredOutcomes, VersionsOfEachProduct_Rise) {
  EXPECT_TRUE(known_versions(Product::ddssec).empty());
  for (const auto product : {Product::cyclonedds, Product::fastdds}) {
    const auto known = known_versions(product);
    ASSERT_FALSE(known.empty());
    EXPECT_TRUE(std::ranges::is_sorted(known, {}, &KnownVersion::version));
    EXPECT_EQ(known.front().version, Lineup().of(product));
  }
}

TEST(MeasuredOutcomes, AnOutcome_IsThatOfTheVersion) {
  const auto itself = [](Lineup lineup) {
    return measured(Variant::permissions_by_itself, lineup);
  };
  EXPECT_EQ(itself({}), (Outcomes{Outcome::unsafe, Outcome::unsafe, Outcome::ok}));
  EXPECT_EQ(itself({.cyclonedds = {11, 0, 1}, .fastdds = {3, 1, 2}}),
            (Outcomes{Outcome::fail, Outcome::fail, Outcome::ok}));
}

}  // namespace
}  // namespace ddssec::governance::doctor
