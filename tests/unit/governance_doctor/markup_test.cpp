// Texts, references and pieces of a configuration.
#include "governance/doctor/markup.hpp"

#include <gtest/gtest.h>

#include "governance/doctor/effective_security.hpp"
#include "tests/unit/governance_doctor/configurations.hpp"

namespace ddssec::governance::doctor::configurations {
namespace {

using Place = ConfigurationPlace;

TEST(EffectiveSecurity, References_AreReadAsUtf8) {
  const auto text = replaced("file:/a/g", "file:&amp;&#x2f;&#233;&#x20AC;&#x1F916;");
  const auto read = effective_security(text, 0, Place::file);
  ASSERT_TRUE(read.access_control);
  EXPECT_EQ(read.access_control->value("governance")->text, "file:&/\u00e9\u20ac\U0001F916");
}

TEST(EffectiveSecurity, ValueInPieces_IsJoinedAsCycloneDdsDoes) {
  for (const auto* value :
       {" file:/a/g\n", "fi<!-- x -->le:/a/g", "<![CDATA[file:/a/g]]>", "file:/&#97;/&#x67;"}) {
    const auto read = effective_security(replaced("file:/a/g", value), 0, Place::file);
    ASSERT_TRUE(read.access_control) << value;
    EXPECT_EQ(read.access_control->value("governance")->text, "file:/a/g");
  }
}

// The text is cut at every octet.
TEST(EffectiveSecurity, CutAnywhere_IsNotSecuredWithoutAProblem) {
  const auto text = document(domain(security()));
  for (std::size_t size = 1; size < text.size(); ++size)
    EXPECT_FALSE(effective_security(text.substr(0, size), 0, Place::file).problems.empty()) << size;
}

}  // namespace
}  // namespace ddssec::governance::doctor::configurations
