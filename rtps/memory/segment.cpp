#include "rtps/memory/segment.hpp"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <linux/magic.h>
#include <numeric>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

// These flags are newer than the headers of some systems. The kernel decides whether it knows them.
#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif
#ifndef MFD_NOEXEC_SEAL
#define MFD_NOEXEC_SEAL 0x0008U
#endif

namespace ddssec::rtps::memory {
namespace {

constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
constexpr std::size_t kMaxSlots = std::size_t{1} << 20;

FileDescriptor make_memory() {
  constexpr unsigned kFlags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  FileDescriptor out(::memfd_create("ddssec", kFlags | MFD_NOEXEC_SEAL));
  if (!out) out = FileDescriptor(::memfd_create("ddssec", kFlags));  // for Linux before 6.3
  if (out) ::fchmod(out.number(), S_IRUSR | S_IWUSR);  // readers need not open it themselves
  return out;
}

bool allocate_memory(int descriptor, std::size_t size) {
  rlimit limit{};
  // The system ends a process that writes above this limit.
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur < size) return false;
  int status = 0;
  do {
    status = ::fallocate(descriptor, 0, 0, static_cast<off_t>(size));
  } while (status != 0 && errno == EINTR);
  return status == 0;
}

MemoryResult<Mapping> map_octets(int descriptor, std::size_t size, int protection, int flags = 0) {
  void* at = ::mmap(nullptr, size, protection, MAP_SHARED | flags, descriptor, 0);
  if (at == MAP_FAILED) return refuse(MemoryRefusal::no_memory);
  // The mapping is not inherited: a child process neither sees nor changes what is written later.
  ::madvise(at, size, MADV_DONTFORK);
  return Mapping({static_cast<std::uint8_t*>(at), size});
}

// The cast is safe: loads do not write, so the mapping may be read-only.
std::atomic_ref<std::uint64_t> generation_of(std::uint8_t* slot) {
  return std::atomic_ref<std::uint64_t>(*static_cast<std::uint64_t*>(static_cast<void*>(slot)));
}

bool is_shape(std::size_t largest, std::size_t count) {
  return largest > 0 && largest <= kMaxSegment && count > 0 && count <= kMaxSlots;
}

MemoryId id_of(const struct stat& info) { return {info.st_dev, info.st_ino}; }

// All pages exist, and the writer cannot take one away, so no access raises SIGBUS or takes memory
// that counts for the reader. The number of blocks would not prove this, because blocks may be
// beyond the end.
bool is_complete(int descriptor, const struct stat& info) {
  if (info.st_size <= 0 || static_cast<std::uint64_t>(info.st_size) > kMaxSegment) return false;
  return ::lseek(descriptor, 0, SEEK_HOLE) == info.st_size;
}

}  // namespace

Mapping::~Mapping() {
  if (!octets_.empty()) ::munmap(octets_.data(), octets_.size());
}

MemoryResult<Segment> Segment::make(std::uint64_t id, std::size_t largest, std::size_t count) {
  if (!is_shape(largest, count)) return refuse(MemoryRefusal::bad_shape);
  const std::size_t slot_size = kSlotHead + (largest + kSlotHead - 1) / kSlotHead * kSlotHead;
  if (slot_size > kMaxSegment / count) return refuse(MemoryRefusal::bad_shape);
  const std::size_t size = slot_size * count;
  Segment out;
  out.id_ = id;
  out.slot_size_ = slot_size;
  out.descriptor_ = make_memory();
  const int number = out.descriptor();
  if (number < 0 || !allocate_memory(number, size)) return refuse(MemoryRefusal::no_memory);
  // The pages are written to at once, because to readers a page that was never written is a hole.
  auto mapping = map_octets(number, size, PROT_READ | PROT_WRITE, MAP_POPULATE);
  if (!mapping) return refuse(mapping.error());
  out.mapping_ = *std::move(mapping);
  if (::fcntl(number, F_ADD_SEALS, kSeals) != 0) return refuse(MemoryRefusal::no_seals);
  struct stat info {};
  if (::fstat(number, &info) != 0 || !is_complete(number, info))
    return refuse(MemoryRefusal::no_memory);
  out.memory_ = id_of(info);
  out.slots_.resize(count);
  out.free_.resize(count);
  std::iota(out.free_.begin(), out.free_.end(), std::size_t{0});
  out.free_count_ = count;
  return out;
}

std::uint8_t* Segment::slot(std::size_t index) const {
  return mapping_.octets().data() + index * slot_size_;
}

MemoryResult<Reference> Segment::store(BytesView payload) {
  if (payload.size() > largest_payload()) return refuse(MemoryRefusal::too_large);
  const auto place = begin();
  if (!place) return refuse(place.error());
  if (!payload.empty()) std::memcpy(place->data(), payload.data(), payload.size());
  return end(payload.size());
}

MemoryResult<MutableBytes> Segment::begin() {
  if (free_count_ == 0) return refuse(MemoryRefusal::full);
  const std::size_t index = free_[first_free_];
  first_free_ = (first_free_ + 1) % free_.size();
  --free_count_;
  slots_[index].is_in_use = true;
  written_ = index;
  // The generation is odd before the first octet changes, and even only after the last one has
  // changed.
  generation_of(slot(index)).store(++slots_[index].generation, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  return MutableBytes(slot(index) + kSlotHead, largest_payload());
}

Reference Segment::end(std::size_t length) {
  const std::size_t index = *std::exchange(written_, std::nullopt);
  generation_of(slot(index)).store(++slots_[index].generation, std::memory_order_release);
  return Reference{.segment = id_,
                   .offset = index * slot_size_,
                   .generation = slots_[index].generation,
                   .length = static_cast<std::uint32_t>(length)};
}

FileDescriptor Segment::for_reader() const {
  const auto path = "/proc/self/fd/" + std::to_string(descriptor());
  // A reader of the same user may have changed the mode.
  ::fchmod(descriptor(), S_IRUSR | S_IWUSR);
  return FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

// A write lease is granted only if this is the only file description of the memory. Our own
// writable one does not count, because it was not opened. A descriptor that was opened for a reader
// counts until no process has it or a mapping with it.
bool Segment::is_with_others() const {
  const auto probe = for_reader();
  if (!probe) return true;
  // This signal would be sent if the lease were broken, and is ignored by default.
  if (::fcntl(probe.number(), F_SETSIG, SIGURG) != 0) return true;
  if (::fcntl(probe.number(), F_SETLEASE, F_WRLCK) != 0) return true;
  ::fcntl(probe.number(), F_SETLEASE, F_UNLCK);
  return false;
}

void Segment::wipe() {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    auto& generation = slots_[i].generation;
    if (generation == 0) continue;
    generation_of(slot(i)).store(++generation, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    std::memset(slot(i) + kSlotHead, 0, largest_payload());
    generation_of(slot(i)).store(++generation, std::memory_order_release);
  }
}

void Segment::cancel() { release(end(0)); }

bool Segment::release(const Reference& reference) {
  const std::size_t index = reference.offset / slot_size_;
  if (reference.segment != id_ || reference.offset % slot_size_ != 0 || index >= slots_.size())
    return false;
  Slot& slot = slots_[index];
  if (!slot.is_in_use || slot.generation != reference.generation) return false;
  slot.is_in_use = false;
  free_[(first_free_ + free_count_) % free_.size()] = index;
  ++free_count_;
  return true;
}

MemoryResult<MappedSegment> MappedSegment::map(const FileDescriptor& descriptor, std::uint64_t id,
                                               MemoryId memory) {
  struct stat info {};
  struct statfs system {};
  const int number = descriptor.number();
  // The seals are checked first, because that involves no file system, which might be another
  // process (FUSE).
  const int seals = ::fcntl(number, F_GET_SEALS);
  if (seals < 0) return refuse(MemoryRefusal::wrong_kind);
  if (::fstat(number, &info) != 0 || !S_ISREG(info.st_mode) || ::fstatfs(number, &system) != 0 ||
      system.f_type != TMPFS_MAGIC)
    return refuse(MemoryRefusal::wrong_kind);
  if ((seals & kSeals) != kSeals) return refuse(MemoryRefusal::not_sealed);
  // The size is read after the seals: only because of them is it final.
  if (::fstat(number, &info) != 0 || !is_complete(number, info))
    return refuse(MemoryRefusal::wrong_size);
  if (id_of(info) != memory) return refuse(MemoryRefusal::other_memory);
  auto mapping = map_octets(number, static_cast<std::size_t>(info.st_size), PROT_READ);
  if (!mapping) return refuse(mapping.error());
  MappedSegment out;
  out.id_ = id;
  out.mapping_ = *std::move(mapping);
  return out;
}

MemoryResult<void> MappedSegment::check(const Reference& reference) const {
  if (reference.segment != id_) return refuse(MemoryRefusal::other_segment);
  const std::size_t size = mapping_.octets().size();
  // The checks subtract, so that no sum overflows.
  if (reference.offset % kSlotHead != 0 || size < kSlotHead ||
      reference.offset > size - kSlotHead || reference.length > size - kSlotHead - reference.offset)
    return refuse(MemoryRefusal::outside);
  const auto generation = generation_of(mapping_.octets().data() + reference.offset);
  if (reference.generation % 2 != 0 || reference.generation == 0 ||
      generation.load(std::memory_order_acquire) != reference.generation)
    return refuse(MemoryRefusal::gone);
  return {};
}

MemoryResult<void> MappedSegment::copy(const Reference& reference, MutableBytes out) const {
  if (const auto leads_there = check(reference); !leads_there) return leads_there;
  if (reference.length != out.size()) return refuse(MemoryRefusal::outside);
  std::uint8_t* const slot = mapping_.octets().data() + reference.offset;
  if (!out.empty()) std::memcpy(out.data(), slot + kSlotHead, out.size());
  std::atomic_thread_fence(std::memory_order_acquire);
  if (generation_of(slot).load(std::memory_order_relaxed) != reference.generation)
    return refuse(MemoryRefusal::gone);
  return {};
}

}  // namespace ddssec::rtps::memory
