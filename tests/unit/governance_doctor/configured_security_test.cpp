// Configurations of Cyclone DDS with which a process does not start, or starts without security.
#include <cstdlib>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/configuration_checks.hpp"
#include "tests/unit/governance_doctor/configurations.hpp"

namespace ddssec::governance::doctor {
namespace {

using configurations::document;
using configurations::domain;
using configurations::replaced;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class DiagnoseEffectiveSecurity : public Folders {
 protected:
  DiagnoseEffectiveSecurity() : loaded_(load_folder(participant("talker"), kNow)) {}

  Diagnosis diagnosis_of(const std::string& text, bool may_run_elsewhere = false) const {
    const auto security = effective_security(text, 0, ConfigurationPlace::file);
    Diagnosis out;
    diagnose_effective_security({.name = "cyclonedds.xml",
                                 .document = "cyclonedds.xml",
                                 .folder = loaded_,
                                 .domain = 0,
                                 .security = security,
                                 .may_run_elsewhere = may_run_elsewhere},
                                out);
    return out;
  }
  // Returns the only finding's sentence; the process does not start with either product.
  std::string refusal(const std::string& text) const {
    const auto said = diagnosis_of(text);
    EXPECT_EQ(said.outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail}));
    EXPECT_THAT(rules_of(said), ElementsAre(Rule::DOC102));
    return rules_of(said).empty() ? "" : finding_of(said, Rule::DOC102).message;
  }
  const LoadedFolder loaded_;
};

std::string with_library(const std::string& attributes) {
  return replaced(
      "<Library path=\"dds_security_auth\" initFunction=\"init_authentication\" "
      "finalizeFunction=\"finalize_authentication\"/>",
      "<Library " + attributes + "/>");
}

TEST_F(DiagnoseEffectiveSecurity, WholeConfiguration_HasNoFinding) {
  for (const char* const library : {"dds_security_auth", "ddssec_authentication"}) {
    const auto said = diagnosis_of(with_library("path='" + std::string(library) + "'"));
    EXPECT_THAT(rules_of(said), IsEmpty());
    EXPECT_TRUE(said.outcomes().all_ok());
  }
}

TEST_F(DiagnoseEffectiveSecurity, NoSecurityAtAll_IsReportedAsOpen) {
  const auto said = diagnosis_of(document(domain("")));
  EXPECT_THAT(rules_of(said), ElementsAre(Rule::DOC101));
  EXPECT_THAT(finding_of(said, Rule::DOC101).message, HasSubstr("has no <Security> for domain 0"));
}

TEST_F(DiagnoseEffectiveSecurity, SecurityOfAnotherDomain_NamesBothDomains) {
  const auto said = diagnosis_of(document(domain(configurations::security(), " Id=\"7\"")));
  EXPECT_THAT(rules_of(said), ElementsAre(Rule::DOC101));
  const auto finding = finding_of(said, Rule::DOC101);
  EXPECT_THAT(finding.message, HasSubstr("for domain 7 only: in domain 0"));
  EXPECT_THAT(finding.hint, HasSubstr("<Domain Id=\"0\">"));
}

TEST_F(DiagnoseEffectiveSecurity, AProblemOfTheText_IsTheOnlyFinding) {
  EXPECT_THAT(refusal(replaced("</Security>", "")),
              HasSubstr("so that Cyclone DDS does not start"));
}

TEST_F(DiagnoseEffectiveSecurity, AccessControlIsMissing_OursDoNotStart) {
  EXPECT_THAT(refusal(replaced(configurations::kAccessControl, "")),
              AllOf(HasSubstr("has no <AccessControl>"), HasSubstr("governance.p7s"),
                    HasSubstr("permissions.p7s")));
}

TEST_F(DiagnoseEffectiveSecurity, AnElementWithoutAValue_IsNamedWithItsLine) {
  EXPECT_THAT(refusal(replaced("<PrivateKey>file:/a/key</PrivateKey>", "")),
              HasSubstr("names no <PrivateKey>"));
  EXPECT_THAT(refusal(replaced("file:/a/g", "")), HasSubstr("names no <Governance>"));
}

TEST_F(DiagnoseEffectiveSecurity, ALibraryOfAnotherPlugin_IsNamedWithBothElements) {
  EXPECT_THAT(refusal(with_library("path='/a/library.so' initFunction='init_access_control'")),
              HasSubstr("names the library of <AccessControl> in <Authentication>"));
}

TEST_F(DiagnoseEffectiveSecurity, AWrongFunction_IsNamedWithTheRightOne) {
  for (const char* const attribute : {"initFunction", "finalizeFunction"}) {
    const auto said = refusal(with_library("path='dds_security_auth' " + std::string(attribute) +
                                           "='begin_authentication'"));
    EXPECT_THAT(said, AllOf(HasSubstr(std::string(attribute) + "=\"begin_authentication\""),
                            HasSubstr("the library's function is")));
  }
}

TEST_F(DiagnoseEffectiveSecurity, ALibraryThatIsNotFound_IsNamed) {
  EXPECT_THAT(refusal(with_library("path='no_such_library'")),
              AllOf(HasSubstr("\"no_such_library\" in <Authentication>, which is not found"),
                    HasSubstr("is \"dds_security_auth\"")));
}

TEST_F(DiagnoseEffectiveSecurity, APathThatIsNotHere_IsSaidOnce) {
  auto text = with_library("path='/no/such/libdds_security_auth.so'");
  const std::string other = "<Cryptographic/>";
  text.replace(
      text.find(other), other.size(),
      "<Cryptographic><Library path='/no/such/libdds_security_crypto.so'/></Cryptographic>");
  EXPECT_THAT(refusal(text), HasSubstr("/no/such/libdds_security_auth.so"));
}

TEST_F(DiagnoseEffectiveSecurity, APathOfAnotherMachine_IsAWarning) {
  const auto said = diagnosis_of(with_library("path='/no/such/libdds_security_auth.so'"), true);
  EXPECT_THAT(rules_of(said), ElementsAre(Rule::DOC007));
  EXPECT_TRUE(said.outcomes().all_ok());
}

TEST_F(DiagnoseEffectiveSecurity, AFileThatIsNoLibrary_IsSaidToBeNone) {
  const auto file = root_ / "libdds_security_auth.so";
  write(file, "text");
  EXPECT_THAT(refusal(with_library("path='" + file.string() + "'")),
              HasSubstr("which is no library of this machine"));
}

TEST_F(DiagnoseEffectiveSecurity, ALibraryWithoutTheFunction_IsRefused) {
  // This program is a library of this machine as the loader sees it, and has no such functions.
  const auto file = root_ / "libother.so";
  fs::copy_file("/proc/self/exe", file);
  const auto said =
      diagnosis_of(with_library("path='" + file.string() + "' initFunction='init_x'"));
  EXPECT_EQ(said.outcomes().ddssec, Outcome::fail);
  EXPECT_THAT(finding_of(said, Rule::DOC102).message, HasSubstr(file.string()));
}

TEST_F(DiagnoseEffectiveSecurity, ATrustedFolder_CountsWithoutAListAndFailsWithOne) {
  const auto with = [](const std::string& elements) {
    return replaced("<IdentityCA>", elements + "<IdentityCA>");
  };
  const std::string folder = "<TrustedCADirectory>/a/cas</TrustedCADirectory>";
  const auto alone = diagnosis_of(with(folder));
  EXPECT_THAT(rules_of(alone), ElementsAre(Rule::DOC008));
  EXPECT_THAT(finding_of(alone, Rule::DOC008).message, HasSubstr("/a/cas"));
  EXPECT_THAT(refusal(with(folder + "<CRL>file:/a/crl</CRL>")),
              HasSubstr("<TrustedCADirectory> and a <CRL>"));
  EXPECT_THAT(rules_of(diagnosis_of(with("<TrustedCADirectory></TrustedCADirectory>"))), IsEmpty());
}

TEST_F(DiagnoseEffectiveSecurity, AVariableThatCannotBeReplaced_IsRefused) {
  EXPECT_THAT(refusal(replaced("file:/a/key", "file:${HOME")), HasSubstr("whose variables"));
}

}  // namespace
}  // namespace ddssec::governance::doctor
