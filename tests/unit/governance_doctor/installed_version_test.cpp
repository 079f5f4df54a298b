// The version of an installed product.
#include "governance/doctor/installed_version.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>

#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {
namespace {

class InstalledVersion : public testing::Test {
 protected:
  InstalledVersion()
      : root_(std::filesystem::path(testing::TempDir()) /
              ("ddssec-installed-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(root_ / "a");
    std::filesystem::create_directories(root_ / "b");
  }
  ~InstalledVersion() override { std::filesystem::remove_all(root_); }
  void touch(const char* name) const { std::ofstream(root_ / name) << ""; }
  std::optional<Version> found(Product product) const {
    return installed_version(product, {root_ / "missing", root_ / "a", root_ / "b"});
  }

  std::filesystem::path root_;
};

TEST_F(InstalledVersion, TheLibrarysName_SaysIt) {
  EXPECT_EQ(found(Product::cyclonedds), std::nullopt);
  for (const auto* name : {"a/libddsc.so", "a/libddsc.so.0debian", "a/libfastrtps.so.2.9",
                           "a/libddscxx.so.0.10.9", "a/libddsc.so.0.10.x"})
    touch(name);
  EXPECT_EQ(found(Product::cyclonedds), std::nullopt);
  EXPECT_EQ(found(Product::fastdds), std::nullopt);
  touch("b/libddsc.so.0.10.5");
  touch("b/libfastrtps.so.2.9.1");
  EXPECT_EQ(found(Product::cyclonedds), (Version{0, 10, 5}));
  EXPECT_EQ(found(Product::fastdds), (Version{2, 9, 1}));
  touch("a/libddsc.so.0.10.2");  // the loader would take this one
  touch("b/libfastdds.so.3.1.2");
  EXPECT_EQ(found(Product::cyclonedds), (Version{0, 10, 2}));
  EXPECT_EQ(found(Product::fastdds), (Version{3, 1, 2}));
  EXPECT_EQ(found(Product::ddssec), std::nullopt);
}

TEST_F(InstalledVersion, Folders_AreThoseOfTheVariableAndThenTheSystems) {
  const auto a = (root_ / "a").string();
  const auto folders = library_folders(":/nowhere:" + a + "::");
  ASSERT_FALSE(folders.empty());
  EXPECT_EQ(folders.front(), a);
  EXPECT_NE(std::ranges::find(folders, "/usr/lib"), folders.end());
}

}  // namespace
}  // namespace ddssec::governance::doctor
