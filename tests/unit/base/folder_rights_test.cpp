#include "base/folder_rights.hpp"

#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

namespace fs = std::filesystem;

class FolderRights : public testing::Test {
 protected:
  FolderRights() { fs::create_directories(inner_); }

  // What is found when `folder` has this mode.
  std::optional<OpenFolder> with_mode(const fs::path& folder, unsigned mode) {
    fs::permissions(folder, static_cast<fs::perms>(mode));
    auto found = open_folder_above(inner_);
    fs::permissions(folder, fs::perms::owner_all);
    return found;
  }

  const test::TemporaryFolder temporary_;
  const fs::path outer_ = fs::canonical(temporary_.path()) / "outer";
  const fs::path inner_ = outer_ / "inner";
};

TEST_F(FolderRights, WhereOnlyTheOwnerWrites_NoFolderIsOpen) {
  for (const unsigned mode : {0700u, 0755u, 0500u}) EXPECT_FALSE(with_mode(inner_, mode)) << mode;
}

TEST_F(FolderRights, AFolderThatOthersMayWrite_IsFoundAtEachLevel) {
  for (const auto& folder : {inner_, outer_})
    for (const unsigned mode : {0770u, 0702u}) {
      const auto found = with_mode(folder, mode);
      ASSERT_TRUE(found) << folder << mode;
      EXPECT_EQ(found->path, folder);
      EXPECT_EQ(found->status.st_mode & 07777, mode);
    }
}

TEST_F(FolderRights, AStickyFolder_IsClosed) {
  EXPECT_FALSE(with_mode(inner_, 01777));
  EXPECT_FALSE(with_mode(outer_, 01777));
}

TEST_F(FolderRights, AnotherOwner_IsFound) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  ASSERT_EQ(::chown(outer_.c_str(), 1, 1), 0);
  const auto found = open_folder_above(inner_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->path, outer_);
  EXPECT_EQ(found->status.st_uid, 1u);
}

TEST_F(FolderRights, AFolderThatIsNotThere_IsFound) {
  const auto found = open_folder_above(inner_ / "nowhere");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->status.st_mode, 0u);
}

}  // namespace
}  // namespace ddssec
