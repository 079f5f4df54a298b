// Files that are missing, cut off, or readable by others.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;

using DiagnosisTest = Folders;

TEST_F(DiagnosisTest, AnEmptyFolder_LacksEverySingleFile) {
  const auto folder = pki::participant_folder(root_ / "empty", pki::FolderLayout::flat);
  fs::create_directories(folder.folder);
  const auto loaded = load_folder(folder, kNow);
  EXPECT_TRUE(loaded.is_empty());
  EXPECT_FALSE(load_folder(participant("talker"), kNow).is_empty());
  const auto all = diagnose(loaded, {.now = kNow});
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC001, Rule::DOC001, Rule::DOC001, Rule::DOC001,
                                         Rule::DOC001, Rule::DOC001));
  EXPECT_EQ(all.outcomes(), Outcomes::all(Outcome::fail));
}

TEST_F(DiagnosisTest, MissingPermissions_HintNamesTheCommandThatMakesThem) {
  const auto folder = participant("talker");
  fs::remove(folder.permissions);
  EXPECT_THAT(finding_of(diagnosis(folder), Rule::DOC001).hint,
              testing::HasSubstr("ddssec permissions new --cert " + folder.certificate.string()));
}

TEST_F(DiagnosisTest, TruncatedFiles_AreFaultsAndNoCrash) {
  const auto folder = participant("talker");
  for (const auto& path : {folder.identity_ca, folder.certificate, folder.key,
                           folder.permissions_ca, folder.governance, folder.permissions}) {
    const auto whole = read(path);
    for (const std::size_t size : {whole.size() / 2, std::size_t{40}, std::size_t{1}}) {
      write(path, whole.substr(0, size));
      EXPECT_FALSE(diagnosis(folder).outcomes().all_ok()) << path << ' ' << size;
    }
    write(path, whole);
  }
  EXPECT_TRUE(diagnosis(folder).outcomes().all_ok());
}

// The rights of the file count even if the governance demands no pre-shared keys.
TEST_F(DiagnosisTest, PassphraseFileThatOthersCanRead_IsReportedWhateverTheGovernanceDemands) {
  const auto folder = participant("talker");
  const auto passphrase = folder.folder / "domain.psk";
  write(passphrase, "7:secret");
  write(folder.properties,
        "dds.sec.crypto.rtps_psk_secret_passphrase = file:" + passphrase.string() + "\n");
  const auto reports = [&] {
    std::vector<std::string> out;
    const auto told = diagnosis(folder);
    for (const auto& check : told.checks())
      for (const auto& finding : check.findings)
        if (finding.rule == ddssec::Rule::DOC003) out.push_back(finding.message);
    return out;
  };
  fs::permissions(passphrase, fs::perms(0644));
  const auto readable = reports();
  ASSERT_EQ(readable.size(), 1u);
  EXPECT_NE(readable[0].find("domain.psk is named for a passphrase by "), std::string::npos)
      << readable[0];
  fs::permissions(passphrase, fs::perms(0600));
  EXPECT_TRUE(reports().empty());
}

}  // namespace
}  // namespace ddssec::governance::doctor
