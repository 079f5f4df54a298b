// Paths that another user can change.
#include "base/guarded_path.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "base/tool_code.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

namespace fs = std::filesystem;
constexpr uid_t kOther = 65534;

// own/inner is a folder of this user, below one that no other user can write to.
class GuardedPath : public testing::Test {
 protected:
  GuardedPath() {
    fs::create_directories(inner_);
    for (const auto& folder : {root_, own_, inner_}) ::chmod(folder.c_str(), 0755);
  }
  bool leads_to_inner(const fs::path& path) const {
    const auto found = open_guarded(path, O_PATH);
    struct stat opened {
    }, there{};
    return found && *found && ::fstat(found->number(), &opened) == 0 &&
           ::stat(inner_.c_str(), &there) == 0 && opened.st_ino == there.st_ino;
  }
  static bool is_untrusted(const fs::path& path) {
    const auto found = open_guarded(path, O_PATH);
    return !found && found.error().code() == tool_code::link_untrusted;
  }
  // True if the result is empty and errno is this error.
  static bool is_refused_with(int error, const fs::path& path) {
    const auto found = open_guarded(path, O_PATH);
    const int seen = errno;
    return found && !*found && seen == error;
  }

  const test::TemporaryFolder folder_;
  const fs::path root_ = folder_.path();
  const fs::path own_ = root_ / "own", inner_ = own_ / "inner";
};

TEST_F(GuardedPath, FoldersWithoutALink_AreOpened) {
  EXPECT_TRUE(leads_to_inner(inner_));
  EXPECT_TRUE(leads_to_inner(root_ / "." / "own" / ".." / "own" / "inner" / ""));
}

TEST_F(GuardedPath, LastName_MustNotBeALink) {
  fs::create_directory_symlink(inner_, own_ / "link");
  EXPECT_TRUE(is_refused_with(ENOTDIR, own_ / "link"));
  EXPECT_TRUE(is_refused_with(ENOENT, own_ / "missing"));
  EXPECT_TRUE(is_refused_with(ENOENT, root_ / "missing" / "inner"));
}

TEST_F(GuardedPath, LinkOfThisUser_IsFollowed) {
  fs::create_directory_symlink(own_, root_ / "absolute");
  fs::create_directory_symlink("own", root_ / "relative");
  EXPECT_TRUE(leads_to_inner(root_ / "absolute" / "inner"));
  EXPECT_TRUE(leads_to_inner(root_ / "relative" / "inner"));
}

TEST_F(GuardedPath, RelativePath_BeginsAtTheWorkingFolder) {
  const test::WorkingFolder here(root_);
  fs::create_directory_symlink("own", root_ / "link");
  EXPECT_TRUE(leads_to_inner("own/inner"));
  EXPECT_TRUE(leads_to_inner("link/inner"));
  EXPECT_TRUE(leads_to_inner("own/inner/."));
}

TEST_F(GuardedPath, LinksInACircle_End) {
  fs::create_directory_symlink("b", root_ / "a");
  fs::create_directory_symlink("a", root_ / "b");
  EXPECT_TRUE(is_refused_with(ELOOP, root_ / "a" / "inner"));
}

TEST_F(GuardedPath, FileInPlaceOfAFolder_IsRefused) {
  folder_.write("file", "");
  EXPECT_TRUE(is_refused_with(ENOTDIR, root_ / "file" / "inner"));
}

TEST_F(GuardedPath, LinkInAFolderThatOthersCanWriteTo_IsNotFollowed) {
  fs::create_directory_symlink(own_, root_ / "link");
  ::chmod(root_.c_str(), 0757);
  const auto refused = open_guarded(root_ / "link" / "inner", O_PATH);
  EXPECT_TRUE(is_untrusted(root_ / "link" / "inner"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().details().field, "link");
  EXPECT_NE(refused.error().details().found.find("mode 0757"), std::string::npos);
  EXPECT_TRUE(leads_to_inner(inner_)) << "without a link it is opened";
}

TEST_F(GuardedPath, OwnLinkInAFolderWithTheStickyBit_IsFollowed) {
  fs::create_directory_symlink(own_, root_ / "link");
  ::chmod(root_.c_str(), 01777);
  EXPECT_TRUE(leads_to_inner(root_ / "link" / "inner"));
}

TEST_F(GuardedPath, LinkBelowAFolderThatOthersCanWriteTo_IsNotFollowed) {
  fs::create_directory_symlink(inner_, own_ / "link");
  fs::create_directory(inner_ / "deep");
  EXPECT_FALSE(is_untrusted(own_ / "link" / "deep"));
  ::chmod(root_.c_str(), 0757);  // another user can put another folder in place of `own`
  EXPECT_TRUE(is_untrusted(own_ / "link" / "deep"));
}

TEST_F(GuardedPath, LinkOfAnotherUser_IsNotFollowed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a link away";
  const auto link = root_ / "link";
  fs::create_directory_symlink(own_, link);
  ASSERT_EQ(::lchown(link.c_str(), kOther, kOther), 0);
  ::chmod(root_.c_str(), 01777);
  EXPECT_TRUE(is_untrusted(link / "inner"));
}

TEST_F(GuardedPath, FolderOfAnotherUser_IsEnteredAndNoLinkInItFollowed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  fs::create_directory_symlink(inner_, own_ / "link");
  fs::create_directory(inner_ / "deep");
  ASSERT_EQ(::chown(own_.c_str(), kOther, kOther), 0);
  EXPECT_TRUE(leads_to_inner(inner_));
  EXPECT_TRUE(is_untrusted(own_ / "link" / "deep"));
}

}  // namespace
}  // namespace ddssec
