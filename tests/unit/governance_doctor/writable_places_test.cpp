// Each way in which another user could replace a file, and rights that give no such way.
#include "governance/doctor/writable_places.hpp"

#include <ctime>
#include <fstream>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::IsEmpty;
using testing::SizeIs;

class WritablePlacesTest : public ::testing::Test {
 protected:
  WritablePlacesTest() {
    fs::create_directories(folder_);
    for (const auto& path : {root_, root_ / "above", folder_, root_ / "other"}) {
      fs::create_directories(path);
      set_mode(path, 0755);
    }
    std::ofstream(file_) << "x";
    set_mode(file_, 0644);
  }
  static void set_mode(const fs::path& path, mode_t mode) {
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
  }
  std::vector<Finding> found(const fs::path& path) const {
    WritablePlaces places(::geteuid());
    places.add_with_way(path);
    return places.findings();
  }
  // Expects that the only finding about the file is about `path`, and says so.
  void expect_open(const fs::path& path, std::string_view message_end, Severity severity) const {
    const auto all = found(file_);
    ASSERT_THAT(all, SizeIs(1));
    EXPECT_EQ(all[0].rule, Rule::DOC104);
    EXPECT_EQ(all[0].document, fs::canonical(path).string());
    EXPECT_THAT(all[0].message, EndsWith(message_end));
    EXPECT_EQ(all[0].severity, severity);
  }

  const test::TemporaryFolder temporary_;
  const fs::path root_ = fs::canonical(temporary_.path());
  const fs::path folder_ = root_ / "above/talker";
  const fs::path file_ = folder_ / "identity_ca.pem";
};

TEST_F(WritablePlacesTest, WhatOnlyItsOwnerCanWrite_IsNone) {
  EXPECT_THAT(found(file_), IsEmpty());
}

TEST_F(WritablePlacesTest, WhatEveryUserCanWrite_IsAnError) {
  for (const auto& [path, mode] :
       {std::pair(file_, 0666), std::pair(folder_, 0777), std::pair(root_ / "above", 0777)}) {
    set_mode(path, static_cast<mode_t>(mode));
    expect_open(path, fmt::format("every user of this machine (mode {:03o})", mode),
                Severity::error);
    set_mode(path, path == file_ ? 0644 : 0755);
  }
}

TEST_F(WritablePlacesTest, FolderAlone_HasNothingAboveIt) {
  set_mode(root_ / "above", 0777);
  WritablePlaces places(::geteuid());
  places.add(folder_);
  EXPECT_THAT(places.findings(), IsEmpty());
  set_mode(folder_, 0777);
  places.add(folder_);
  places.add(folder_);
  EXPECT_THAT(places.findings(), SizeIs(1));
}

TEST_F(WritablePlacesTest, StickyFolder_HoldsTheNamesOfTheOwner) {
  set_mode(root_ / "above", 01777);
  EXPECT_THAT(found(file_), IsEmpty());
  set_mode(folder_, 01777);
  EXPECT_THAT(found(file_), IsEmpty());
}

TEST_F(WritablePlacesTest, LinkIntoAFolderOfAll_IsFollowed) {
  std::ofstream(root_ / "other/ca.pem") << "x";
  set_mode(root_ / "other/ca.pem", 0644);
  fs::remove(file_);
  fs::create_symlink("../../other/ca.pem", file_);
  EXPECT_THAT(found(file_), IsEmpty());
  set_mode(root_ / "other", 0777);
  expect_open(root_ / "other", "every user of this machine (mode 777)", Severity::error);
}

TEST_F(WritablePlacesTest, LinkInAFolderOfAll_IsReportedThoughItsTargetIsNot) {
  fs::create_symlink("../above", root_ / "other/way");
  set_mode(root_ / "other", 0777);
  const auto all = found(root_ / "other/way/talker/identity_ca.pem");
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].document, (root_ / "other").string());
}

TEST_F(WritablePlacesTest, CircleOfLinks_Ends) {
  fs::remove(file_);
  fs::create_symlink("identity_ca.pem", file_);
  EXPECT_THAT(found(file_), IsEmpty());
}

// Each link leads through all before it.
TEST_F(WritablePlacesTest, LongPathOfLinks_EndsSoon) {
  fs::create_symlink(".", folder_ / "here");
  std::string path;
  for (int i = 0; i < 35; ++i) path += "here/";
  fs::remove(file_);
  fs::create_symlink(path + "second", file_);
  fs::create_symlink(path + "third", folder_ / "second");
  const auto begin = std::clock();
  EXPECT_THAT(found(file_), IsEmpty());
  EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC / 10);
}

TEST_F(WritablePlacesTest, AnotherUserOrGroup_IsAWarning) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  constexpr uid_t kOther = 12'345;
  ASSERT_EQ(::chown(folder_.c_str(), kOther, 0), 0);
  expect_open(folder_, "belongs to the user 12345, and the participant to root", Severity::warning);
  WritablePlaces of_owner(kOther);
  of_owner.add_with_way(file_);
  EXPECT_THAT(of_owner.findings(), IsEmpty());
  ASSERT_EQ(::chown(folder_.c_str(), 0, kOther), 0);
  EXPECT_THAT(found(file_), IsEmpty());
  set_mode(folder_, 0775);
  expect_open(folder_, "can be written by the group 12345 (mode 775)", Severity::warning);
  ASSERT_EQ(::chown(folder_.c_str(), 0, 0), 0);
  EXPECT_THAT(found(file_), IsEmpty());
}

TEST_F(WritablePlacesTest, AccessControlListThatLetsAnotherUserWrite_IsAWarning) {
  // An entry of acl(5): owner rw-, user 12345 rw-, group ---, mask, others ---.
  struct [[gnu::packed]] Entry {
    std::uint16_t tag, rights;
    std::uint32_t id;
  };
  struct [[gnu::packed]] List {
    std::uint32_t version = 2;
    Entry entries[5] = {
        {0x01, 6, ~0U}, {0x02, 6, 12'345}, {0x04, 0, ~0U}, {0x10, 6, ~0U}, {0x20, 0, ~0U}};
  } list;
  const auto set = [&] {
    return ::setxattr(file_.c_str(), "system.posix_acl_access", &list, sizeof list, 0) == 0;
  };
  if (!set()) GTEST_SKIP() << "this file system has no access control lists";
  expect_open(file_, "can be written by the user 12345 (access control list)", Severity::warning);
  list.entries[3].rights = 4;  // the mask takes this right away
  ASSERT_TRUE(set());
  EXPECT_THAT(found(file_), IsEmpty());
}

TEST_F(WritablePlacesTest, NameOfAnotherUserInAStickyFolder_IsReported) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  set_mode(folder_, 01777);
  ASSERT_EQ(::chown(file_.c_str(), 12'345, 0), 0);
  EXPECT_THAT(found(file_), SizeIs(2));
}

}  // namespace
}  // namespace ddssec::governance::doctor
