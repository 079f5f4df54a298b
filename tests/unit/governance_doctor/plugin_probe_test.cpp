#include "governance/doctor/plugin_probe.hpp"

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec::governance::doctor {
namespace {

using Answer = PluginProbe::Result;

TEST(PluginProbe, ALibraryWithItsFunctions_Works) {
  EXPECT_EQ(probe_plugin(DDSSEC_PROBED_whole, "crypto").result, Answer::works);
}

TEST(PluginProbe, TheMissingFunction_IsNamed) {
  const auto probe = probe_plugin(DDSSEC_PROBED_whole, "authentication");
  EXPECT_EQ(probe.result, Answer::lacks_entry);
  EXPECT_EQ(probe.detail, "init_authentication");
}

TEST(PluginProbe, ALibraryThatCrashes_HurtsNoOther) {
  EXPECT_EQ(probe_plugin(DDSSEC_PROBED_crashing, "crypto").result, Answer::died);
}

TEST(PluginProbe, TheLoadersReason_IsTold) {
  const auto probe = probe_plugin("/nowhere/libdds_security_auth.so", "authentication");
  EXPECT_EQ(probe.result, Answer::not_loadable);
  EXPECT_THAT(probe.detail, testing::HasSubstr("/nowhere/libdds_security_auth.so"));
}

TEST(PluginProbe, AFolderThatDoesNotExist_IsOneFaultOfOurs) {
  Diagnosis out;
  diagnose_plugins("/nowhere", out);
  EXPECT_THAT(rules_of(out), testing::ElementsAre(Rule::DOC070));
  EXPECT_EQ(out.outcomes(), (Outcomes{.ddssec = Outcome::fail}));
}

TEST(PluginProbe, AFolderWithoutLibraries_IsThreeFaultsOfOurs) {
  const test::TemporaryFolder folder;
  Diagnosis out;
  diagnose_plugins(folder.path(), out);
  EXPECT_THAT(rules_of(out), testing::ElementsAre(Rule::DOC070, Rule::DOC070, Rule::DOC070));
  EXPECT_EQ(out.outcomes(), (Outcomes{.ddssec = Outcome::fail}));
}

}  // namespace
}  // namespace ddssec::governance::doctor
