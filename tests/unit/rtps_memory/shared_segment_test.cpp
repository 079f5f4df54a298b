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

// What the child tells of its segment.
struct ToldByChild {
  int descriptor = -1;
  MemoryId id = {};
  Reference first = {};  // a payload that stays until the parent has answered
};

// Stores payloads in a segment of one slot, until the process is killed. The first one is there
// until an octet comes from the parent.
[[noreturn]] void write_until_killed(int to_parent, int from_parent) {
  auto writer = segment(100000, 1);
  const ToldByChild told{writer.descriptor(), writer.memory(), *writer.store(Bytes(100000, 0x11))};
  char answer = 0;
  if (::write(to_parent, &told, sizeof told) < 0 || ::read(from_parent, &answer, 1) != 1)
    ::_exit(1);
  for (auto last = told.first;; last = *writer.store(Bytes(100000, 0x22))) writer.release(last);
}

TEST(CrashedWriter, Writer_KilledWhileItWrites_LeavesReadersUnharmed) {
  std::array<int, 2> up{}, down{};
  ASSERT_EQ(::pipe(up.data()), 0);
  ASSERT_EQ(::pipe(down.data()), 0);
  const FileDescriptor in(up[0]), out_of_child(up[1]), into_child(down[0]), answer(down[1]);
  const pid_t child = ::fork();
  if (child == 0) write_until_killed(up[1], down[0]);
  ToldByChild told;
  ASSERT_EQ(::read(in.number(), &told, sizeof told), ssize_t{sizeof told});
  const auto reader = MappedSegment::map(descriptor_of(child, told.descriptor), kId, told.id);
  ASSERT_TRUE(reader.has_value());
  Bytes out(100000);
  ASSERT_TRUE(reader->copy(told.first, out).has_value()) << "nothing can be read at all";
  ASSERT_EQ(out, Bytes(100000, 0x11));
  ASSERT_EQ(::write(answer.number(), "x", 1), 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_FALSE(reader->copy(told.first, out).has_value()) << "the child did not write again";
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
