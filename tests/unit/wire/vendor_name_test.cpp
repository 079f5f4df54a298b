// Products by their vendor ids, and their versions.
#include "wire/vendor_name.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

TEST(VendorName, KnownVendor_HasTheNameOfItsProduct) {
  EXPECT_EQ(name_of(kVendorCyclone), "Cyclone DDS");
  EXPECT_EQ(name_of(kVendorFastDds), "Fast DDS");
  EXPECT_EQ(name_of(kVendorDdssec), "ddssec");
}

TEST(VendorName, AnotherVendor_HasItsIdAsName) {
  const VendorId other{{1, 2}};
  EXPECT_EQ(name_of(other), "vendor " + other.to_string());
}

TEST(VendorVersion, UpToAnother_IsComparedByItsTwoNumbers) {
  for (const auto* version : {"0.10.2", "0.10", "0.9", "0.10rc1"})
    EXPECT_TRUE(is_up_to(version, 0, 10)) << version;
  for (const auto* version : {"0.11", "1.0", "10", "", "x.1", "0.", "0.x"})
    EXPECT_FALSE(is_up_to(version, 0, 10)) << version;
}

}  // namespace
}  // namespace ddssec::rtps
