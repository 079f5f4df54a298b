// Files that are missing or cut off.
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

}  // namespace
}  // namespace ddssec::governance::doctor
