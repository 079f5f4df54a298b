#include "rtps/memory/segment.hpp"

#include <array>
#include <atomic>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ddssec::rtps::memory {
namespace {

constexpr std::uint64_t kId = 7;
constexpr int kAllSeals = F_SEAL_SHRINK | F_SEAL_GROW | 0x0010 | F_SEAL_SEAL;

Segment segment(std::size_t largest = 1000, std::size_t count = 4) {
  auto out = Segment::make(kId, largest, count);
  EXPECT_TRUE(out.has_value());
  return *std::move(out);
}

// Uses up the free slots, and returns how many there were.
std::size_t free_slots(Segment& segment) {
  std::size_t out = 0;
  while (segment.store({})) ++out;
  return out;
}

FileDescriptor copy_of(const Segment& segment) {
  return FileDescriptor(::fcntl(segment.descriptor(), F_DUPFD_CLOEXEC, 0));
}

MappedSegment mapped(const Segment& segment) {
  auto out = MappedSegment::map(copy_of(segment), segment.id(), segment.memory());
  EXPECT_TRUE(out.has_value());
  return *std::move(out);
}

MemoryRefusal refusal_of(const MappedSegment& segment, const Reference& reference) {
  Bytes out(reference.length < 4096 ? reference.length : 0);
  auto status = segment.copy(reference, out);
  EXPECT_FALSE(status.has_value());
  return status ? MemoryRefusal::no_socket : status.error();
}

// Makes the memory of a hostile writer: `size` octets, of which the first `taken` exist.
FileDescriptor memory(off_t size, off_t taken, int seals, unsigned flags = MFD_ALLOW_SEALING) {
  FileDescriptor out(::memfd_create("test", flags));
  EXPECT_EQ(::ftruncate(out.number(), size), 0);
  if (taken > 0) {
    EXPECT_EQ(::fallocate(out.number(), 0, 0, taken), 0);
  }
  if (seals != 0) {
    EXPECT_EQ(::fcntl(out.number(), F_ADD_SEALS, seals), 0);
  }
  return out;
}

MemoryId id_of(const FileDescriptor& descriptor) {
  struct stat info {};
  EXPECT_EQ(::fstat(descriptor.number(), &info), 0);
  return {info.st_dev, info.st_ino};
}

MemoryRefusal refusal_of_map(const FileDescriptor& descriptor) {
  auto out = MappedSegment::map(descriptor, kId, id_of(descriptor));
  EXPECT_FALSE(out.has_value());
  return out ? MemoryRefusal::no_socket : out.error();
}

TEST(Segment, Payload_StoredByTheWriter_IsCopiedByTheReader) {
  auto writer = segment();
  const auto reader = mapped(writer);
  const Bytes payload(1000, 0x5a);
  const auto reference = writer.store(payload);
  ASSERT_TRUE(reference.has_value());
  Bytes out(reference->length);
  ASSERT_TRUE(reader.copy(*reference, out).has_value());
  EXPECT_EQ(out, payload);
  EXPECT_EQ(free_slots(writer), writer.slots() - 1);
}

TEST(Segment, Payload_Empty_IsCopied) {
  auto writer = segment();
  const auto reader = mapped(writer);
  const auto reference = writer.store({});
  ASSERT_TRUE(reference.has_value());
  EXPECT_TRUE(reader.copy(*reference, {}).has_value());
}

TEST(Segment, Shapes_ThatCannotBe_AreRefused) {
  constexpr auto kMax = std::numeric_limits<std::size_t>::max();
  for (const auto& [largest, count] : std::vector<std::pair<std::size_t, std::size_t>>{
           {0, 1}, {1, 0}, {kMax, 1}, {1, kMax}, {kMaxSegment, 1}, {kMax, kMax}}) {
    const auto out = Segment::make(kId, largest, count);
    ASSERT_FALSE(out.has_value()) << largest << " " << count;
    EXPECT_EQ(out.error(), MemoryRefusal::bad_shape);
  }
}

TEST(Segment, Payload_LargerThanASlot_IsRefused) {
  auto writer = segment(64, 2);
  EXPECT_EQ(writer.store(Bytes(65)).error(), MemoryRefusal::too_large);
  EXPECT_EQ(free_slots(writer), 2U);
}

TEST(Segment, Slots_AllInUse_RefuseUntilOneIsReleased) {
  auto writer = segment(64, 2);
  const auto first = writer.store(Bytes(64, 1));
  ASSERT_TRUE(writer.store(Bytes(64, 2)).has_value());
  EXPECT_EQ(writer.store(Bytes(64, 3)).error(), MemoryRefusal::full);
  EXPECT_TRUE(writer.release(*first));
  EXPECT_TRUE(writer.store(Bytes(64, 3)).has_value());
}

TEST(Segment, Slot_FreedLongestAgo_IsUsedFirst) {
  auto writer = segment(64, 3);
  const auto first = writer.store(Bytes(1));
  ASSERT_TRUE(writer.release(*first));
  // Two other slots were free before this one, and are used first.
  EXPECT_NE(writer.store(Bytes(1))->offset, first->offset);
  EXPECT_NE(writer.store(Bytes(1))->offset, first->offset);
  EXPECT_EQ(writer.store(Bytes(1))->offset, first->offset);
}

TEST(Segment, Release_OfASlotNotInUse_DoesNothing) {
  auto writer = segment(64, 2);
  const auto first = writer.store(Bytes(1));
  ASSERT_TRUE(writer.release(*first));
  EXPECT_FALSE(writer.release(*first));
  auto wrong = *writer.store(Bytes(1));
  wrong.generation += 2;
  EXPECT_FALSE(writer.release(wrong));
  wrong.offset = std::numeric_limits<std::uint64_t>::max();
  EXPECT_FALSE(writer.release(wrong));
  EXPECT_EQ(free_slots(writer), 1U);
}

TEST(Segment, Copy_OfASlotUsedAgain_IsGone) {
  auto writer = segment(64, 1);
  const auto reader = mapped(writer);
  const auto old = writer.store(Bytes(64, 1));
  ASSERT_TRUE(writer.release(*old));
  ASSERT_TRUE(writer.store(Bytes(64, 2)).has_value());
  EXPECT_EQ(refusal_of(reader, *old), MemoryRefusal::gone);
}

TEST(Segment, Copy_OfASlotNeverUsedOrBeingWritten_IsGone) {
  auto writer = segment(64, 2);
  const auto reader = mapped(writer);
  auto reference = *writer.store(Bytes(64, 1));
  const auto slot = reference.offset;
  for (const std::uint64_t generation : {0U, 1U, 3U, 4U}) {
    reference.generation = generation;
    EXPECT_EQ(refusal_of(reader, reference), MemoryRefusal::gone) << generation;
  }
  reference.offset = slot == 0 ? 128 : 0;
  reference.generation = 0;
  EXPECT_EQ(refusal_of(reader, reference), MemoryRefusal::gone);
}

TEST(Segment, Copy_OutsideTheSegment_IsRefused) {
  auto writer = segment(64, 2);
  const auto reader = mapped(writer);
  const auto good = *writer.store(Bytes(64, 1));
  constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
  for (const std::uint64_t offset : {std::uint64_t{1}, std::uint64_t{63}, std::uint64_t{256},
                                     std::uint64_t{1} << 40, kMax, kMax - 63, kMax - 127}) {
    auto reference = good;
    reference.offset = offset;
    EXPECT_EQ(refusal_of(reader, reference), MemoryRefusal::outside) << offset;
  }
  auto last = good;
  last.offset = 192;  // only the head of a slot fits there
  EXPECT_EQ(refusal_of(reader, last), MemoryRefusal::outside);
  Bytes more(256);
  auto longer = good;
  longer.length = 256;
  EXPECT_EQ(reader.copy(longer, more).error(), MemoryRefusal::outside);
}

TEST(Segment, Copy_ToAPlaceOfAnotherSize_IsRefused) {
  auto writer = segment();
  const auto reader = mapped(writer);
  const auto reference = *writer.store(Bytes(64, 1));
  Bytes out(63);
  EXPECT_EQ(reader.copy(reference, out).error(), MemoryRefusal::outside);
}

TEST(Segment, Copy_FromAnotherSegment_IsRefused) {
  auto writer = segment();
  const auto reader = mapped(writer);
  auto reference = *writer.store(Bytes(64, 1));
  reference.segment = kId + 1;
  EXPECT_EQ(refusal_of(reader, reference), MemoryRefusal::other_segment);
}

// Each payload repeats one octet, so a copy that mixes two payloads is noticed.
TEST(Segment, Copy_WhileTheSlotIsUsedAgain_IsWholeOrGone) {
  constexpr std::size_t kSize = 20000;
  auto writer = segment(kSize, 2);
  const auto reader = mapped(writer);
  std::array<std::atomic<std::uint64_t>, 2> generations{};
  std::atomic<bool> ended = false;
  std::atomic<std::size_t> whole = 0;
  std::thread writing([&] {
    // The loop goes on if this machine gave the reader no time yet, but not for ever.
    for (int i = 0; i < 20000 || (whole == 0 && i < 5000000); ++i) {
      const auto reference = writer.store(Bytes(kSize, static_cast<std::uint8_t>(i)));
      generations[reference->offset == 0 ? 0 : 1] = reference->generation;
      writer.release(*reference);
    }
    ended = true;
  });
  bool mixed = false;  // no ASSERT here, because the thread must be joined
  Bytes out(kSize);
  while (!ended) {
    const Reference reference{
        .segment = kId, .offset = 0, .generation = generations[0], .length = kSize};
    if (!reader.copy(reference, out)) continue;
    ++whole;
    if (out != Bytes(kSize, out.front())) mixed = true;
  }
  writing.join();
  EXPECT_FALSE(mixed);
  EXPECT_GT(whole.load(), 0U);
}

TEST(SegmentSeals, Memory_OfASegment_CannotBeWrittenOrResizedByAReader) {
  auto writer = segment();
  const auto descriptor = copy_of(writer);
  const int number = descriptor.number();
  EXPECT_EQ(::mmap(nullptr, 64, PROT_READ | PROT_WRITE, MAP_SHARED, number, 0), MAP_FAILED);
  EXPECT_LT(::pwrite(number, "x", 1, 0), 0);
  EXPECT_NE(::ftruncate(number, 0), 0);
  EXPECT_NE(::ftruncate(number, 1 << 20), 0);
  EXPECT_NE(::fallocate(number, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), 0);
  EXPECT_NE(::fcntl(number, F_ADD_SEALS, F_SEAL_WRITE), 0);
  void* const read_only = ::mmap(nullptr, 64, PROT_READ, MAP_SHARED, number, 0);
  ASSERT_NE(read_only, MAP_FAILED);
  EXPECT_NE(::mprotect(read_only, 64, PROT_READ | PROT_WRITE), 0);
  ::munmap(read_only, 64);
  const FileDescriptor again(
      ::open(("/proc/self/fd/" + std::to_string(number)).c_str(), O_RDWR | O_CLOEXEC));
  if (again) {
    EXPECT_LT(::pwrite(again.number(), "x", 1, 0), 0);
  }
}

// A writer that becomes hostile after the reader mapped its memory cannot take a page away.
TEST(SegmentSeals, Memory_ThatAReaderMapped_CannotBePunchedByTheWriter) {
  const auto descriptor = memory(8192, 8192, 0);
  void* const own =
      ::mmap(nullptr, 8192, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor.number(), 0);
  ASSERT_NE(own, MAP_FAILED);
  std::memset(own, 1, 8192);
  ASSERT_EQ(::fcntl(descriptor.number(), F_ADD_SEALS, kAllSeals), 0);
  EXPECT_TRUE(MappedSegment::map(descriptor, kId, id_of(descriptor)).has_value());
  EXPECT_NE(::madvise(own, 8192, MADV_REMOVE), 0);
  ::munmap(own, 8192);
}

TEST(SegmentMapping, Descriptor_OfAnotherKind_IsRefused) {
  EXPECT_EQ(MappedSegment::map(FileDescriptor(), kId, {}).error(), MemoryRefusal::wrong_kind);
  EXPECT_EQ(refusal_of_map(FileDescriptor(::open("/dev/zero", O_RDWR))), MemoryRefusal::wrong_kind);
  EXPECT_EQ(refusal_of_map(FileDescriptor(::open("/tmp", O_RDONLY | O_DIRECTORY))),
            MemoryRefusal::wrong_kind);
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const FileDescriptor other(ends[1]);
  EXPECT_EQ(refusal_of_map(FileDescriptor(ends[0])), MemoryRefusal::wrong_kind);
}

TEST(SegmentMapping, File_OfASharedFolder_IsRefused) {
  const std::string path = "/dev/shm/ddssec_segment_test_" + std::to_string(::getpid());
  const FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!file) GTEST_SKIP() << "no /dev/shm";
  ::unlink(path.c_str());
  ASSERT_EQ(::fallocate(file.number(), 0, 0, 4096), 0);
  const auto refusal = refusal_of_map(file);
  EXPECT_TRUE(refusal == MemoryRefusal::not_sealed || refusal == MemoryRefusal::wrong_kind);
}

// The pages may be missing although the memory is sealed.
TEST(SegmentMapping, Memory_OfHugePages_IsRefused) {
  const FileDescriptor huge(::memfd_create("test", MFD_ALLOW_SEALING | MFD_HUGETLB));
  if (!huge || ::fcntl(huge.number(), F_ADD_SEALS, kAllSeals) != 0) GTEST_SKIP() << "no huge pages";
  EXPECT_EQ(refusal_of_map(huge), MemoryRefusal::wrong_kind);
}

TEST(SegmentMapping, Memory_WithoutOneOfTheSeals_IsRefused) {
  for (const int missing : {F_SEAL_SHRINK, F_SEAL_GROW, 0x0010, F_SEAL_SEAL})
    EXPECT_EQ(refusal_of_map(memory(4096, 4096, kAllSeals & ~missing)), MemoryRefusal::not_sealed)
        << missing;
  EXPECT_EQ(refusal_of_map(memory(4096, 4096, 0)), MemoryRefusal::not_sealed);
}

TEST(SegmentMapping, Memory_EmptyOrTooLarge_IsRefused) {
  EXPECT_EQ(refusal_of_map(memory(0, 0, kAllSeals)), MemoryRefusal::wrong_size);
  EXPECT_EQ(refusal_of_map(memory(off_t{1} << 40, 0, kAllSeals)), MemoryRefusal::wrong_size);
}

TEST(SegmentMapping, Memory_WithAHole_IsRefused) {
  EXPECT_EQ(refusal_of_map(memory(16384, 0, kAllSeals)), MemoryRefusal::wrong_size);
  EXPECT_EQ(refusal_of_map(memory(16384, 8192, kAllSeals)), MemoryRefusal::wrong_size);
}

// Such blocks count as memory of the file, but lie where the reader never looks.
TEST(SegmentMapping, Memory_WithBlocksBeyondItsEnd_IsRefused) {
  const auto beyond = memory(16384, 0, 0);
  ASSERT_EQ(::fallocate(beyond.number(), FALLOC_FL_KEEP_SIZE, 16384, 16384), 0);
  ASSERT_EQ(::fcntl(beyond.number(), F_ADD_SEALS, kAllSeals), 0);
  struct stat info {};
  ASSERT_EQ(::fstat(beyond.number(), &info), 0);
  ASSERT_GE(info.st_blocks * 512, info.st_size);
  EXPECT_EQ(refusal_of_map(beyond), MemoryRefusal::wrong_size);
}

TEST(SegmentMapping, Memory_OfASegment_IsAllThere) {
  for (const std::size_t largest : {std::size_t{64}, std::size_t{3} << 20}) {
    const auto whole = segment(largest, 3);
    EXPECT_EQ(::lseek(whole.descriptor(), 0, SEEK_HOLE), static_cast<off_t>(whole.octets()));
  }
}

TEST(SegmentMapping, Memory_OtherThanTheOffered_IsRefused) {
  const auto writer = segment();
  const auto other = segment();
  const auto out = MappedSegment::map(copy_of(other), kId, writer.memory());
  ASSERT_FALSE(out.has_value());
  EXPECT_EQ(out.error(), MemoryRefusal::other_memory);
}

// Runs in a process of its own, because a limit that was lowered cannot be raised again.
int status_of_child(int (*run)()) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(run());
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

int refused_with_no_memory() {
  const auto out = Segment::make(kId, std::size_t{1} << 20, 16);
  return !out && out.error() == MemoryRefusal::no_memory ? 0 : 1;
}

TEST(SegmentLimits, ExhaustedDescriptors_AreRefused) {
  EXPECT_EQ(status_of_child([] {
              const rlimit none{.rlim_cur = 0, .rlim_max = 0};
              return ::setrlimit(RLIMIT_NOFILE, &none) == 0 ? refused_with_no_memory() : 2;
            }),
            0);
}

TEST(SegmentLimits, AddressSpace_Exhausted_Refuses) {
  EXPECT_EQ(status_of_child([] {
              const rlimit none{.rlim_cur = 0, .rlim_max = 0};
              return ::setrlimit(RLIMIT_AS, &none) == 0 ? refused_with_no_memory() : 2;
            }),
            0);
}

TEST(SegmentLimits, FileSize_Limited_RefusesAndRaisesNoSignal) {
  EXPECT_EQ(status_of_child([] {
              const rlimit small{.rlim_cur = 4096, .rlim_max = 4096};
              return ::setrlimit(RLIMIT_FSIZE, &small) == 0 ? refused_with_no_memory() : 2;
            }),
            0);
}

}  // namespace
}  // namespace ddssec::rtps::memory
