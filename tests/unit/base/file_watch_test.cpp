#include "base/file_watch.hpp"

#include <thread>

#include <gtest/gtest.h>

#include "base/uri_source.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

using namespace std::chrono_literals;

// Polls as a participant does: once per interval, and once more after a reported change.
class Looker {
 public:
  explicit Looker(const std::string& path) : watch_("file:" + path, 5s) { settle(); }
  bool poll() { return watch_.may_have_changed(now_ += 5s); }
  // True if a change is seen. Then looks until nothing changes any more.
  bool sees_a_change() {
    const bool seen = poll();
    settle();
    return seen;
  }
  void settle() {
    std::this_thread::sleep_for(20ms);  // so that the next change has another time
    for (int i = 0; i < 2; ++i) poll();
    EXPECT_FALSE(poll());
  }
  const std::string& uri() const { return watch_.uri(); }

 private:
  FileWatch watch_;
  std::chrono::nanoseconds now_ = 1h;
};

TEST(FileWatch, EveryKindOfChange_IsSeen) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("list", "one");
  Looker looker(path);
  folder.write("list", "two");  // has the same size
  EXPECT_TRUE(looker.sees_a_change());
  folder.replace("list", "two");
  EXPECT_TRUE(looker.sees_a_change());
  std::ofstream(path, std::ios::app) << "more";
  EXPECT_TRUE(looker.sees_a_change());
  std::filesystem::permissions(path, std::filesystem::perms::owner_read);
  EXPECT_TRUE(looker.sees_a_change());
  std::filesystem::remove(path);
  EXPECT_TRUE(looker.sees_a_change());
  folder.write("list", "back");
  EXPECT_TRUE(looker.sees_a_change());
}

// The time between two questions of a host varies with what it does before them.
TEST(FileWatch, AQuestionALittleBeforeTheInterval_LooksAtTheFile) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("list", "one");
  FileWatch watch("file:" + path, 1s);
  for (const auto at : {10s, 11s, 12s}) watch.may_have_changed(at);
  std::this_thread::sleep_for(20ms);
  folder.write("list", "more");
  EXPECT_FALSE(watch.may_have_changed(12s + 800ms));
  EXPECT_TRUE(watch.may_have_changed(12s + 980ms));
}

TEST(FileWatch, OldTimeOnNewContent_IsSeen) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("list", "one");
  const auto before = std::filesystem::last_write_time(path);
  Looker looker(path);
  folder.replace("list", "two");
  std::filesystem::last_write_time(path, before);
  EXPECT_TRUE(looker.sees_a_change());
}

TEST(FileWatch, Links_AreFollowed) {
  const test::TemporaryFolder folder;
  folder.write("a", "same");
  folder.write("b", "same");
  const auto link = folder.path() + "/list";
  std::filesystem::create_symlink("a", link);
  Looker looker(link);
  std::filesystem::create_symlink("b", folder.path() + "/new");
  std::filesystem::rename(folder.path() + "/new", link);
  EXPECT_TRUE(looker.sees_a_change());
  folder.write("b", "else");
  EXPECT_TRUE(looker.sees_a_change());
}

TEST(FileWatch, RelativePath_NamesTheSameFileAfterChdir) {
  const test::TemporaryFolder first, second;
  const test::WorkingFolder at(first.path());
  first.write("list", "one");
  Looker looker("list");
  const test::WorkingFolder elsewhere(second.path());
  second.write("list", "other");
  EXPECT_FALSE(looker.sees_a_change());
  first.write("list", "two");
  EXPECT_TRUE(looker.sees_a_change());
  EXPECT_EQ(looker.uri(), "file:" + first.path() + "/list");
}

TEST(AbsoluteUri, OnlyARelativePath_IsChanged) {
  const test::TemporaryFolder folder;
  const test::WorkingFolder at(folder.path());
  const auto absolute = "file:" + folder.path();
  EXPECT_EQ(absolute_uri("file:a/b.pem"), absolute + "/a/b.pem");
  EXPECT_EQ(absolute_uri(" \tfile://b.pem"), absolute + "/b.pem");
  for (const auto* same : {"file:/a", "file:///a", " file:/a", "file:", "data:,file:a",
                           "pkcs11:token=a;object=b?pin-source=file:pin", "a.pem", ""})
    EXPECT_EQ(absolute_uri(same), same);
}

TEST(AbsoluteUri, NoWorkingFolder_NamesNothing) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() + "/gone");
  const test::WorkingFolder at(folder.path() + "/gone");
  std::filesystem::remove(folder.path() + "/gone");
  EXPECT_EQ(absolute_uri("file:b.pem"), "");
  EXPECT_EQ(absolute_uri("file:/b.pem"), "file:/b.pem");
}

// If two changes fall within one tick of the file system's clock, only the first one may be
// visible.
TEST(FileWatch, ChangedFile_IsLookedAtOnceMore) {
  const test::TemporaryFolder folder;
  FileWatch watch("file:" + folder.write("list", "one"), 5s);
  EXPECT_TRUE(watch.may_have_changed(5s));
  EXPECT_FALSE(watch.may_have_changed(10s));
  folder.write("list", "three");
  EXPECT_TRUE(watch.may_have_changed(15s));
  EXPECT_TRUE(watch.may_have_changed(20s));
  EXPECT_FALSE(watch.may_have_changed(25s));
}

TEST(FileWatch, WithinAnInterval_AsksOnceAtMost) {
  const test::TemporaryFolder folder;
  FileWatch watch("file:" + folder.write("list", "one"), 5s);
  EXPECT_TRUE(watch.may_have_changed(0s));
  folder.write("list", "two");
  EXPECT_FALSE(watch.may_have_changed(4s));
  EXPECT_TRUE(watch.may_have_changed(5s));
}

TEST(FileWatch, UnusableFile_IsLookedAtAgain) {
  const test::TemporaryFolder folder;
  FileWatch watch("file:" + folder.write("list", "one"), 1s);
  EXPECT_TRUE(watch.may_have_changed(1s));
  EXPECT_FALSE(watch.may_have_changed(2s));
  watch.force_change();
  EXPECT_FALSE(watch.may_have_changed(2500ms));
  EXPECT_TRUE(watch.may_have_changed(3s));
  EXPECT_FALSE(watch.may_have_changed(4s));
}

TEST(FileWatch, WatchWithoutAFileOrAnInterval_ReportsNothing) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("list", "one");
  FileWatch off("file:" + path, 0s), text("data:,one", 5s), none("", 5s), wrong("http://x", 5s);
  folder.replace("list", "two");
  for (auto* watch : {&off, &text, &none, &wrong}) {
    watch->force_change();
    for (int i = 1; i < 4; ++i) EXPECT_FALSE(watch->may_have_changed(i * 5s));
  }
}

}  // namespace
}  // namespace ddssec
