#include "governance/doctor/host_plugins.hpp"

#include <elf.h>
#include <fstream>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "tests/unit/governance_doctor/libraries.hpp"

namespace ddssec::governance::doctor::libraries {
namespace {

using PluginProduct = HostPlugin::PluginProduct;

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(HostPlugins, SeveralFolders_AreThoseThatTheLoaderFindsFirst) {
  path({"nowhere", "ours", "old"});
  EXPECT_THAT(products(), ElementsAre("ddssec 1.2.3", "ddssec 1.2.3", "ddssec 1.2.3"));
  EXPECT_EQ(found()[0].file, root_ / "ours/libdds_security_auth.so");
  EXPECT_EQ(found()[1].role, "access control");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  path({"old", "ours"});
  EXPECT_THAT(products(), ElementsAre("ddssec", "ddssec", "ddssec"));
}

TEST_F(HostPlugins, AnotherProductsPlugins_AreNoFaultWhereNothingNamesOurs) {
  path({});
  EXPECT_EQ(found()[2].product, PluginProduct::other);
  EXPECT_EQ(found()[2].file, root_ / "system/private/libdds_security_crypto.so");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  EXPECT_THAT(said().checks(), IsEmpty());
}

TEST_F(HostPlugins, AnotherProduct_IsReportedInAFolderThatWasMadeForOurs) {
  path({});
  were_ours_meant_ = true;
  EXPECT_THAT(message(), HasSubstr("runs the stock plugins, not ddssec's: authentication: stock"));
  EXPECT_EQ(said().outcomes(),
            (Outcomes{}));  // it starts, and a user without Cyclone DDS may not care
  EXPECT_THAT(finding_of(said(), Rule::DOC068).hint,
              HasSubstr("lib/ddssec/dropin of an installation"));
  places_.dropin = "/opt/ddssec/lib/ddssec/dropin";
  EXPECT_THAT(finding_of(said(), Rule::DOC068).hint,
              HasSubstr("export LD_LIBRARY_PATH=/opt/ddssec/lib/ddssec/dropin${LD_LIBRARY_PATH"));
  path({"ours"});
  EXPECT_THAT(rules_of(said()), IsEmpty());
  fs::remove_all(root_ / "system");
  path({});
  EXPECT_THAT(rules_of(said()), IsEmpty());  // this machine has no Cyclone DDS
}

TEST_F(HostPlugins, PluginsOfTwoProducts_AreTold) {
  fs::remove(root_ / "ours/libdds_security_ac.so");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("authentication: ddssec 1.2.3"));
  EXPECT_THAT(message(), HasSubstr("access control: stock, not ddssec's (" +
                                   (root_ / "system/private").string()));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ddssec = Outcome::unsafe}));
}

TEST_F(HostPlugins, PluginsOfTwoVersions_AreTold) {
  put("ours", "crypto", "ddssec_x ddssec plugin version 1.2.4");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("of two versions: authentication: ddssec 1.2.3"));
}

TEST_F(HostPlugins, MissingPlugins_AreTold) {
  fs::remove(root_ / "ours/libdds_security_ac.so");
  fs::remove(root_ / "system/private/libdds_security_ac.so");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("access control: not found"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail}));
}

TEST_F(HostPlugins, AnotherProduct_IsReportedWhereOursWereMeant) {
  fs::create_directories(root_ / "links");
  for (const auto* name : kNames)
    fs::create_symlink("../lib/gone.so",
                       root_ / ("links/libdds_security_" + std::string(name) + ".so"));
  path({"links"});
  EXPECT_THAT(message(), HasSubstr("libdds_security_auth.so is a link that leads nowhere"));
  path({"my-dropin"});
  EXPECT_THAT(message(), HasSubstr("my-dropin is no folder"));
  path({"system/private", "ours"});
  EXPECT_THAT(message(), HasSubstr("ours/libdds_security_auth.so is ddssec's, and"));
  fs::create_directories(root_ / "lib");
  std::ofstream(root_ / "lib/libddssec_authentication.so") << "ddssec_";
  path({"lib"});
  EXPECT_THAT(message(), HasSubstr("under names that the configuration does not name"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ddssec = Outcome::fail}));
}

TEST_F(HostPlugins, NameWithAPath_CountsAsItIs) {
  auto text = std::string(kConfiguration);
  const std::string name = "dds_security_ac";
  text.replace(text.find(name), name.size(), (root_ / "old/libdds_security_ac.so").string());
  EXPECT_EQ(host_plugins(text, places_)[1].product, PluginProduct::ddssec);
  Diagnosis judged;
  diagnose_host_plugins(host_plugins(text, places_), places_, true, judged);
  EXPECT_THAT(rules_of(judged), ElementsAre(Rule::DOC068));  // the folder has files of two products
  put_file("old", "ac", elf_that_needs("libnowhere.so.23"));
  const auto unloadable = host_plugins(text, places_);
  Diagnosis told;
  diagnose_loadable(unloadable, told);
  EXPECT_EQ(told.outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail}));
  EXPECT_THAT(finding_of(told, Rule::DOC068).message, HasSubstr("Cyclone DDS does not start"));
  // DOC102 reports a missing file, which is no question of the loader.
  fs::remove(root_ / "old/libdds_security_ac.so");
  Diagnosis missing;
  diagnose_host_plugins(host_plugins(text, places_), places_, true, missing);
  EXPECT_THAT(rules_of(missing), IsEmpty());
  text.replace(text.find((root_ / "old").string()), (root_ / "old").string().size(), "${HOME}/x");
  EXPECT_THAT(host_plugins(text, places_), IsEmpty());
}

TEST_F(HostPlugins, ConfigurationWithoutSecurity_HasNone) {
  EXPECT_THAT(host_plugins("<CycloneDDS/>", places_), IsEmpty());
  EXPECT_THAT(host_plugins("", places_), IsEmpty());
  EXPECT_EQ(plugins_of_node(places_).size(), 3u);
}

}  // namespace
}  // namespace ddssec::governance::doctor::libraries
