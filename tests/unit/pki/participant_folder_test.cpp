#include "pki/participant_folder.hpp"

#include <unistd.h>

#include <gtest/gtest.h>

#include "pki_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec::pki {
namespace {

namespace fs = std::filesystem;

class Folder : public testing::Test {
 protected:
  void touch(const char* name) { folder_.write(name, "x"); }

  const test::TemporaryFolder folder_;
  const fs::path at_ = folder_.path();
};

TEST_F(Folder, AnEmptyOne_IsTakenAsFlat) {
  const auto files = participant_folder(at_);
  EXPECT_EQ(files.layout, FolderLayout::flat);
  EXPECT_EQ(files.identity_ca, at_ / "identity_ca.pem");
  EXPECT_EQ(files.permissions_ca, at_ / "permissions_ca.pem");
  EXPECT_EQ(files.certificate, at_ / "cert.pem");
  EXPECT_EQ(files.key, at_ / "key.pem");
  EXPECT_EQ(files.governance, at_ / "governance.p7s");
  EXPECT_EQ(files.permissions, at_ / "permissions.p7s");
  EXPECT_EQ(files.crl, at_ / "crl.pem");
}

TEST_F(Folder, OneCaFile_TellsTheLayout) {
  touch("permissions_ca.cert.pem");
  const auto files = participant_folder(at_);
  EXPECT_EQ(files.layout, FolderLayout::sros2);
  EXPECT_EQ(files.identity_ca, at_ / "identity_ca.cert.pem");
  EXPECT_EQ(files.permissions_ca, at_ / "permissions_ca.cert.pem");
  EXPECT_EQ(files.key, at_ / "key.pem");
}

TEST_F(Folder, ABrokenLink_CountsAndFlatNamesWin) {
  fs::create_symlink("nowhere", at_ / "identity_ca.cert.pem");
  EXPECT_EQ(participant_folder(at_).layout, FolderLayout::sros2);
  touch("identity_ca.pem");
  EXPECT_EQ(participant_folder(at_).layout, FolderLayout::flat);
}

TEST_F(Folder, OneFileOfItsOwn_TellsAParticipantsFolder) {
  EXPECT_FALSE(is_participant_folder(at_));
  for (const auto* const name : {"cert.pem", "identity_ca.pem", "identity_ca.cert.pem"}) {
    touch(name);
    EXPECT_TRUE(is_participant_folder(at_)) << name;
    fs::remove(at_ / name);
  }
  touch("ca.pem");
  EXPECT_FALSE(is_participant_folder(at_));
}

TEST_F(Folder, ACertificateOrAKeyOfACa_TellsACasFolder) {
  EXPECT_FALSE(is_ca_folder(at_));
  fs::create_directory(at_ / "identity");
  for (const auto* const name : {"ca.pem", "ca.key.pem", "identity/ca.pem"}) {
    touch(name);
    EXPECT_TRUE(is_ca_folder(at_)) << name;
    fs::remove(at_ / name);
  }
  touch("identity_ca.pem");
  EXPECT_FALSE(is_ca_folder(at_));
}

TEST_F(Folder, ModeOfTheFolder_TellsWhetherOthersCanChangeIt) {
  for (const auto& [mode, open] : {std::pair(0700, false), std::pair(0755, false),
                                   std::pair(0775, true), std::pair(01777, true)}) {
    fs::permissions(at_, static_cast<fs::perms>(mode));
    EXPECT_EQ(may_be_changed_by_others(participant_folder(at_)), open) << std::oct << mode;
  }
  fs::permissions(at_, fs::perms::owner_all);
  EXPECT_TRUE(may_be_changed_by_others(participant_folder(at_ / "nowhere")));
  EXPECT_FALSE(may_be_changed_by_others(participant_folder("/"))) << "root's";
}

TEST_F(Folder, ModeOfAFolderAbove_TellsWhetherOthersCanChangeIt) {
  fs::create_directory(at_ / "talker");
  EXPECT_FALSE(may_be_changed_by_others(participant_folder(at_ / "talker")));
  fs::permissions(at_, fs::perms::all);
  EXPECT_TRUE(may_be_changed_by_others(participant_folder(at_ / "talker")));
  fs::permissions(at_, fs::perms::owner_all);
}

TEST_F(Folder, FileThatOthersCanWrite_TellsThatTheyCanChangeIt) {
  const fs::perms open = fs::perms::owner_all | fs::perms::others_write;
  for (const auto* const name : {"key.p11", "cert.pem", "security.properties"}) {
    touch(name);
    EXPECT_FALSE(may_be_changed_by_others(participant_folder(at_))) << name;
    fs::permissions(at_ / name, open);
    EXPECT_TRUE(may_be_changed_by_others(participant_folder(at_))) << name;
    fs::remove(at_ / name);
  }
  fs::create_directory(at_ / "elsewhere");
  folder_.write("elsewhere/key.pem", "x");
  fs::create_symlink("elsewhere/key.pem", at_ / "key.pem");
  EXPECT_FALSE(may_be_changed_by_others(participant_folder(at_)));
  fs::permissions(at_ / "elsewhere", open);
  EXPECT_TRUE(may_be_changed_by_others(participant_folder(at_))) << "the folder of a link's target";
}

TEST_F(Folder, FileOfAnotherUser_TellsThatOthersCanChangeIt) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  touch("security.properties");
  ASSERT_EQ(::chown((at_ / "security.properties").c_str(), 1234, 1234), 0);
  EXPECT_TRUE(may_be_changed_by_others(participant_folder(at_)));
}

// A document that cannot be reached must not count as one that does not exist.
TEST_F(Folder, FileThatCannotBeReached_IsNotAbsent) {
  touch("crl.pem");
  EXPECT_TRUE(may_exist(at_ / "crl.pem"));
  EXPECT_FALSE(may_exist(at_ / "renewed.pem"));
  EXPECT_FALSE(may_exist(at_ / "nowhere" / "crl.pem"));
  EXPECT_FALSE(may_exist(at_ / "crl.pem" / "crl.pem")) << "below a file";
  EXPECT_FALSE(may_exist(at_ / std::string(300, 'x'))) << "a name longer than the system allows";
  fs::create_symlink("nowhere", at_ / "dangling.pem");
  EXPECT_TRUE(may_exist(at_ / "dangling.pem"));
  fs::create_directory_symlink("loop", at_ / "loop");
  EXPECT_TRUE(may_exist(at_ / "loop" / "crl.pem")) << "a folder that cannot be searched";
}

}  // namespace
}  // namespace ddssec::pki
