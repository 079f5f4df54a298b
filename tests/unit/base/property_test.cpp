#include "base/property.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

const PropertyList kList = {{"a", "1"}, {"b", ""}, {"a", "2"}};

TEST(Property, NameThatOccursTwice_GivesTheFirstValue) {
  EXPECT_EQ(find_property(kList, "a"), &kList[0].value);
  EXPECT_EQ(property_value(kList, "a"), "1");
}

TEST(Property, AbsentName_IsTellableFromAnEmptyValue) {
  EXPECT_EQ(find_property(kList, "b"), &kList[1].value);
  EXPECT_EQ(find_property(kList, "c"), nullptr);
  EXPECT_EQ(property_value(kList, "b"), "");
  EXPECT_EQ(property_value(kList, "c"), "");
}

}  // namespace
}  // namespace ddssec
