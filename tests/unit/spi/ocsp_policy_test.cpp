#include "plugins/spi/ocsp_policy.hpp"

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"
#include "tests/support/expect_code.hpp"

namespace ddssec::spi {
namespace {

Result<OcspPolicy> policy_of(std::string value) {
  return ocsp_policy({{std::string(property::kOcsp), std::move(value)}});
}

TEST(OcspPolicyProperty, OtherThanThreeWords_IsRefused) {
  EXPECT_EQ(ocsp_policy({}), OcspPolicy::soft);
  EXPECT_EQ(policy_of("ignore"), OcspPolicy::ignore);
  EXPECT_EQ(policy_of("soft"), OcspPolicy::soft);
  EXPECT_EQ(policy_of("hard"), OcspPolicy::hard);
  for (const auto* wrong : {"", "Hard", "hard ", "true", "1"})
    EXPECT_CODE(policy_of(wrong), invalid_property);
}

}  // namespace
}  // namespace ddssec::spi
