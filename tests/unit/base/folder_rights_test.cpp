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

  // Returns what open_folder_above() finds while `folder` has this mode.
  std::optional<fs::path> with_mode(const fs::path& folder, unsigned mode) const {
    fs::permissions(folder, static_cast<fs::perms>(mode));
    auto found = open_folder_above(inner_);
    fs::permissions(folder, fs::perms::owner_all);
    return found;
  }

  const test::TemporaryFolder temporary_;
  const fs::path outer_ = fs::canonical(temporary_.path()) / "outer";
  const fs::path inner_ = outer_ / "inner";
};

TEST_F(FolderRights, FolderThatOnlyItsOwnerWrites_IsNotOpen) {
  for (const unsigned mode : {0700u, 0755u, 0500u}) EXPECT_FALSE(with_mode(inner_, mode)) << mode;
}

TEST_F(FolderRights, AFolderThatOthersMayWrite_IsFoundAtEachLevel) {
  for (const auto& folder : {inner_, outer_})
    for (const unsigned mode : {0770u, 0702u}) EXPECT_EQ(with_mode(folder, mode), folder) << mode;
}

TEST_F(FolderRights, AStickyFolder_IsClosed) {
  EXPECT_FALSE(with_mode(inner_, 01777));
  EXPECT_FALSE(with_mode(outer_, 01777));
}

TEST_F(FolderRights, AnotherOwner_IsFound) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  ASSERT_EQ(::chown(outer_.c_str(), 1, 1), 0);
  EXPECT_EQ(open_folder_above(inner_), outer_);
  EXPECT_EQ(owner_and_mode(outer_).substr(0, 13), "user 1, mode ");
}

TEST_F(FolderRights, AFolderThatIsNotThere_IsFound) {
  EXPECT_EQ(open_folder_above(inner_ / "nowhere"), inner_ / "nowhere");
  EXPECT_EQ(owner_and_mode(inner_ / "nowhere"), "nothing");
}

}  // namespace
}  // namespace ddssec
