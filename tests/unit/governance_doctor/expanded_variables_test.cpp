// Variables in values of a configuration, as Cyclone DDS replaces them.
#include "governance/doctor/expanded_variables.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

namespace ddssec::governance::doctor {
namespace {

struct ExpandedVariables : testing::Test {
  ExpandedVariables() {
    ::setenv("DDSSEC_TEST_SET", "value", 1);
    ::unsetenv("DDSSEC_TEST_UNSET");
  }
  ~ExpandedVariables() override { ::unsetenv("DDSSEC_TEST_SET"); }
};

TEST_F(ExpandedVariables, VariablesInBraces_AreReplaced) {
  EXPECT_EQ(expanded_variables("a/${DDSSEC_TEST_SET}/b", 0), "a/value/b");
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_UNSET}", 0), "");
  EXPECT_EQ(expanded_variables("plain", 0), "plain");
}

TEST_F(ExpandedVariables, VariablesWithoutBraces_Stay) {
  EXPECT_EQ(expanded_variables("$DDSSEC_TEST_SET", 0), "$DDSSEC_TEST_SET");
}

TEST_F(ExpandedVariables, VariablesWithAnAlternative_HaveItOnlyWhereItIsFor) {
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_UNSET:-other}", 0), "other");
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_SET:-other}", 0), "value");
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_SET:+other}", 0), "other");
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_UNSET:+other}", 0), "");
}

TEST_F(ExpandedVariables, RequiredVariables_AreRefusedIfTheyAreNotSet) {
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_SET:?why}", 0), "value");
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_UNSET:?why}", 0), std::nullopt);
  EXPECT_EQ(expanded_variables("${DDSSEC_TEST_SET", 0), std::nullopt) << "no end";
}

}  // namespace
}  // namespace ddssec::governance::doctor
