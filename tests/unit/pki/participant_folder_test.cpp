#include "pki/participant_folder.hpp"

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "fixture.hpp"

namespace ddssec::pki {
namespace {

namespace fs = std::filesystem;

class Folder : public testing::Test {
 protected:
  Folder() {
    auto name = (fs::temp_directory_path() / "ddssec-folder-XXXXXX").string();
    at_ = ::mkdtemp(name.data()) != nullptr ? name : "";
  }
  ~Folder() override { fs::remove_all(at_); }
  void touch(const char* name) { std::ofstream(at_ / name) << "x"; }

  fs::path at_;
};

TEST_F(Folder, AnEmptyOneIsTakenAsFlat) {
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

TEST_F(Folder, OneCaFileTellsTheLayout) {
  touch("permissions_ca.cert.pem");
  const auto files = participant_folder(at_);
  EXPECT_EQ(files.layout, FolderLayout::sros2);
  EXPECT_EQ(files.identity_ca, at_ / "identity_ca.cert.pem");
  EXPECT_EQ(files.permissions_ca, at_ / "permissions_ca.cert.pem");
  EXPECT_EQ(files.key, at_ / "key.pem");
}

TEST_F(Folder, ABrokenLinkCountsAndFlatNamesWin) {
  fs::create_symlink("nowhere", at_ / "identity_ca.cert.pem");
  EXPECT_EQ(participant_folder(at_).layout, FolderLayout::sros2);
  touch("identity_ca.pem");
  EXPECT_EQ(participant_folder(at_).layout, FolderLayout::flat);
}

}  // namespace
}  // namespace ddssec::pki
