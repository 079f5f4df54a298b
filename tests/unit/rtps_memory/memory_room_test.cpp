#include "rtps/memory/memory_room.hpp"

#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>

namespace ddssec::rtps::memory {
namespace {

// A folder with files in the form of /proc and /sys.
struct Root {
  Root() { std::filesystem::create_directories(path); }
  ~Root() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& content) const {
    const auto at = std::filesystem::path(path + name);
    std::filesystem::create_directories(at.parent_path());
    std::ofstream(at) << content;
  }
  std::optional<std::uint64_t> room() const { return memory_room(path); }
  bool has_room(std::uint64_t octets) const { return has_memory_room(octets, path); }
  const std::string path = ::testing::TempDir() + "memory_room" + std::to_string(::getpid());
};

TEST(MemoryRoom, NoFiles_NotKnown) { EXPECT_FALSE(Root().room()); }

TEST(MemoryRoom, VersionTwo_LeastOfAllGroupsAbove) {
  Root root;
  root.write("/proc/self/cgroup", "0::/a/b\n");
  root.write("/sys/fs/cgroup/a/b/memory.max", "max\n");
  root.write("/sys/fs/cgroup/a/b/memory.current", "100\n");
  EXPECT_FALSE(root.room());
  root.write("/sys/fs/cgroup/a/memory.max", "1000\n");
  root.write("/sys/fs/cgroup/a/memory.current", "300\n");
  EXPECT_EQ(root.room(), 700u);
  root.write("/sys/fs/cgroup/a/b/memory.max", "500\n");
  EXPECT_EQ(root.room(), 400u);
}

// Beyond this limit (MemoryHigh= of systemd) nothing is refused, but the processes nearly stop.
TEST(MemoryRoom, LimitBeyondWhichProcessesAreSlowed_Counts) {
  Root root;
  root.write("/proc/self/cgroup", "0::/a\n");
  root.write("/sys/fs/cgroup/a/memory.max", "max\n");
  root.write("/sys/fs/cgroup/a/memory.high", "800\n");
  root.write("/sys/fs/cgroup/a/memory.current", "300\n");
  EXPECT_EQ(root.room(), 500u);
  root.write("/sys/fs/cgroup/a/memory.max", "700\n");
  EXPECT_EQ(root.room(), 400u);
}

TEST(MemoryRoom, FilesThatCanBeDropped_AreNotCounted) {
  Root root;
  root.write("/proc/self/cgroup", "0::/\n");
  root.write("/sys/fs/cgroup/memory.max", "1000\n");
  root.write("/sys/fs/cgroup/memory.current", "900\n");
  root.write("/sys/fs/cgroup/memory.stat", "anon 200\nactive_file 5\ninactive_file 600\n");
  EXPECT_EQ(root.room(), 700u);
}

TEST(MemoryRoom, MoreUsedThanAllowed_IsNone) {
  Root root;
  root.write("/proc/self/cgroup", "0::/\n");
  root.write("/sys/fs/cgroup/memory.max", "1000\n");
  root.write("/sys/fs/cgroup/memory.current", "1001\n");
  EXPECT_EQ(root.room(), 0u);
}

// In a container the path is that of the host, and only the top of the hierarchy is mounted.
TEST(MemoryRoom, VersionOneMountedAtTheTop_IsFound) {
  Root root;
  root.write("/proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/docker/1\n0::/\n");
  root.write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "2000\n");
  root.write("/sys/fs/cgroup/memory/memory.usage_in_bytes", "1500\n");
  root.write("/sys/fs/cgroup/memory/memory.stat", "total_inactive_file 100\n");
  EXPECT_EQ(root.room(), 600u);
}

TEST(MemoryRoom, AsMuchAgain_MustBeLeft) {
  Root root;
  root.write("/proc/self/cgroup", "0::/\n");
  root.write("/sys/fs/cgroup/memory.max", "1000\n");
  root.write("/sys/fs/cgroup/memory.current", "300\n");
  ASSERT_EQ(root.room(), 700u);
  EXPECT_TRUE(root.has_room(0));
  EXPECT_TRUE(root.has_room(350));
  EXPECT_FALSE(root.has_room(351));
  EXPECT_FALSE(root.has_room(700));
}

TEST(MemoryRoom, HostWithoutALimit_HasRoomForAnySize) {
  Root root;
  root.write("/proc/self/cgroup", "0::/\n");
  root.write("/sys/fs/cgroup/memory.max", "max\n");
  root.write("/sys/fs/cgroup/memory.current", "300\n");
  EXPECT_TRUE(root.has_room(std::uint64_t{1} << 60));
}

}  // namespace
}  // namespace ddssec::rtps::memory
