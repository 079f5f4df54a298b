// Other processes that have a segment: they crash, fork, and keep it or not.
#include <array>
#include <csignal>
#include <fcntl.h>
#include <optional>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>

#include "tests/unit/rtps_memory/hostile_sockets.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr std::uint64_t kId = 7;

Segment segment(std::size_t largest = 1000, std::size_t count = 4) {
  auto out = Segment::make(kId, largest, count);
  EXPECT_TRUE(out.has_value());
  return *std::move(out);
}

MappedSegment mapped(const Segment& segment) {
  return *MappedSegment::map(segment.for_reader(), segment.id(), segment.memory());
}

// Opens a descriptor that another process has.
FileDescriptor descriptor_of(pid_t process, int number) {
  const auto path = "/proc/" + std::to_string(process) + "/fd/" + std::to_string(number);
  return FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
}

TEST(CrashedWriter, Writer_KilledWhileItWrites_LeavesReadersUnharmed) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const FileDescriptor in(ends[0]), out_of_child(ends[1]);
  const pid_t child = ::fork();
  if (child == 0) {
    auto writer = segment(100000, 1);
    const auto id = writer.memory();
    const int number = writer.descriptor();
    if (::write(ends[1], &number, sizeof number) < 0 || ::write(ends[1], &id, sizeof id) < 0)
      ::_exit(1);
    for (;;) {
      const auto reference = writer.store(Bytes(100000, 0x11));
      writer.release(*reference);
    }
  }
  int number = -1;
  MemoryId id;
  ASSERT_EQ(::read(in.number(), &number, sizeof number), ssize_t{sizeof number});
  ASSERT_EQ(::read(in.number(), &id, sizeof id), ssize_t{sizeof id});
  const auto reader = MappedSegment::map(descriptor_of(child, number), kId, id);
  ASSERT_TRUE(reader.has_value());
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  Bytes out(100000);
  // One of these generations is the last one. All others are gone, and reading them does not end
  // this process.
  int whole = 0;
  for (std::uint64_t generation = 2; generation < 200000; generation += 2) {
    const Reference reference{
        .segment = kId, .offset = 0, .generation = generation, .length = 100000};
    if (!reader->check(reference)) continue;
    whole += reader->copy(reference, out).has_value() ? 1 : 0;
  }
  EXPECT_LE(whole, 1);
}

TEST(Fork, Child_HasNeitherSidesMapping) {
  auto writer = segment();
  const auto reader = mapped(writer);
  const auto reference = *writer.store(Bytes(100, 1));
  ASSERT_TRUE(reader.check(reference).has_value());
  for (const bool as_reader : {false, true}) {
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit none{.rlim_cur = 0, .rlim_max = 0};
      ::setrlimit(RLIMIT_CORE, &none);
      ::signal(SIGSEGV, SIG_DFL);
      const bool found =
          as_reader ? reader.check(reference).has_value() : writer.store(Bytes(100, 2)).has_value();
      ::_exit(found ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV) << status;
  }
}

// ---- whether other processes have it

TEST(SegmentsHeldByOthers, ClosedByTheOthers_IsFree) {
  auto writer = segment();
  EXPECT_FALSE(writer.is_with_others());
  ASSERT_TRUE(writer.store(Bytes(10, 1)).has_value());
  EXPECT_FALSE(writer.is_with_others());
  writer.unmap();
  EXPECT_FALSE(writer.is_with_others());
}

TEST(SegmentsHeldByOthers, OpenOrMapped_IsSeen) {
  const auto writer = segment();
  {
    const auto open = writer.for_reader();
    EXPECT_TRUE(writer.is_with_others());
  }
  EXPECT_FALSE(writer.is_with_others());
  {
    const auto mapping = *MappedSegment::map(writer.for_reader(), kId, writer.memory());
    EXPECT_TRUE(writer.is_with_others()) << "its descriptor is closed by now";
  }
  EXPECT_FALSE(writer.is_with_others());
}

TEST(SegmentsHeldByOthers, SentAndNotReceived_IsSeen) {
  const auto writer = segment();
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends.data()), 0);
  const FileDescriptor near(ends[0]);
  std::optional<FileDescriptor> far(ends[1]);
  {
    const auto open = writer.for_reader();
    ASSERT_EQ(testing::send_with(near, {open.number()}), 1);
  }
  EXPECT_TRUE(writer.is_with_others());
  far.reset();
  EXPECT_FALSE(writer.is_with_others());
}

// A reader may open its descriptor again, even for writing. The memory stays sealed.
TEST(SegmentsHeldByOthers, OpenedOnceMoreByAReader_IsSeen) {
  const auto writer = segment();
  for (const int flags : {O_RDONLY, O_RDWR}) {
    const FileDescriptor again(::open(
        ("/proc/self/fd/" + std::to_string(writer.descriptor())).c_str(), flags | O_CLOEXEC));
    ASSERT_TRUE(again);
    EXPECT_TRUE(writer.is_with_others());
    EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, again.number(), 0),
              MAP_FAILED);
  }
  EXPECT_FALSE(writer.is_with_others());
}

TEST(SegmentsHeldByOthers, ReaderForbidsAll_OthersStillGetIt) {
  const auto writer = segment();
  {
    const auto hostile = writer.for_reader();
    ASSERT_EQ(::fchmod(hostile.number(), 0), 0);
    EXPECT_TRUE(writer.for_reader());
  }
  EXPECT_FALSE(writer.is_with_others());
}

TEST(SegmentsHeldByOthers, OtherProcess_IsSeenUntilItEnds) {
  const auto writer = segment();
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const auto mapping = MappedSegment::map(writer.for_reader(), kId, writer.memory());
    if (::write(ends[1], "x", 1) != 1 || !mapping) ::_exit(1);
    for (;;) ::pause();
  }
  char octet = 0;
  ASSERT_EQ(::read(ends[0], &octet, 1), 1);
  EXPECT_TRUE(writer.is_with_others());
  ::kill(child, SIGKILL);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_FALSE(writer.is_with_others());
  for (const int end : ends) ::close(end);
}

}  // namespace
}  // namespace ddssec::rtps::memory
