// Payloads in memory that one process writes and others only read.
//
// The writer makes the memory (memfd), maps it, and seals it. After that its size cannot change,
// and no process can map or open it for writing, including the writer. The existing mapping of the
// writer stays writable. A reader copies, and checks a generation before and after, so that it
// notices if the content was replaced meanwhile. Readers write nothing, so none of them can harm
// the writer or another reader.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/file_descriptor.hpp"
#include "rtps/memory/memory_refusal.hpp"
#include "wire/memory_reference.hpp"

namespace ddssec::rtps::memory {

/// The place of a payload. A reader trusts only a reference that arrived with the protection that
/// DATA must have.
using Reference = MemoryReference;

/// Identifies the memory of a descriptor, as fstat reports it.
struct MemoryId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;

  bool operator==(const MemoryId&) const = default;
};

/// A mapping that the destructor removes.
class Mapping {
 public:
  Mapping() = default;
  explicit Mapping(MutableBytes octets) : octets_(octets) {}
  ~Mapping();
  Mapping(Mapping&& other) noexcept : octets_(std::exchange(other.octets_, {})) {}
  Mapping& operator=(Mapping&& other) noexcept {
    std::swap(octets_, other.octets_);
    return *this;
  }
  MutableBytes octets() const { return octets_; }

 private:
  MutableBytes octets_;
};

/// The head of a slot, in octets; a payload follows. It has a cache line, so that slots do not
/// share one.
inline constexpr std::size_t kSlotHead = 64;
/// The largest segment that is made or mapped, in octets.
inline constexpr std::size_t kMaxSegment = std::size_t{1} << 30;

/// The writer's side of a segment. Not thread-safe. Allocates only in `make`.
class Segment {
 public:
  /// Makes `count` slots for payloads of up to `largest` octets. All of the memory is taken now and
  /// written to, so that no reader finds a page missing. A system without memory refuses, but in a
  /// memory cgroup at its limit the system ends a process instead. Errors: bad_shape, no_memory,
  /// no_seals.
  static MemoryResult<Segment> make(std::uint64_t id, std::size_t largest, std::size_t count);

  /// Copies the payload into the slot that has been free for longest. Errors: too_large, full.
  MemoryResult<Reference> store(BytesView payload);
  /// As store, in two steps. `begin` returns a slot to write to, of largest_payload() octets, and
  /// `end` its reference once the first `length` of them are written. Until then readers find
  /// nothing there. Error: full.
  MemoryResult<MutableBytes> begin();
  Reference end(std::size_t length);
  /// Ends the writing without a payload.
  void cancel();
  /// Notes that no reader needs the slot any longer. Its content stays until the slot is used
  /// again. Returns false if the reference is not of a slot in use.
  bool release(const Reference& reference);

  std::size_t slots() const { return slots_.size(); }
  std::size_t octets() const { return slot_size_ * slots_.size(); }
  std::size_t largest_payload() const { return slot_size_ - kSlotHead; }
  std::uint64_t id() const { return id_; }
  MemoryId memory() const { return memory_; }
  int descriptor() const { return descriptor_.number(); }
  /// Returns a descriptor for one reader, opened for this reader alone, so that `is_with_others`
  /// knows of it. Empty if the system gave none, or if /proc is missing.
  FileDescriptor for_reader() const;
  /// True if a descriptor for a reader, or a mapping that was made with one, still exists in any
  /// process or on its way to one. Also true if that cannot be determined (Linux before 5.3, leases
  /// off). A descriptor that is only a path (O_PATH) is not noticed; see MemoryEnd.
  bool is_with_others() const;
  /// Overwrites all payloads that were ever written. No slot may be in use.
  void wipe();
  /// Ends reading and writing. The memory lasts for as long as the descriptor does.
  void unmap() { mapping_ = Mapping(); }

 private:
  struct Slot {
    std::uint64_t generation = 0;
    bool is_in_use = false;
  };
  Segment() = default;
  std::uint8_t* slot(std::size_t index) const;

  std::uint64_t id_ = 0;
  std::size_t slot_size_ = 0;
  MemoryId memory_;
  FileDescriptor descriptor_;
  Mapping mapping_;
  std::vector<Slot> slots_;  // the writer's own copy, because the memory itself is not trusted
  std::vector<std::size_t> free_;  // a ring: `free_count_` slots from `first_free_` on
  std::size_t first_free_ = 0;
  std::size_t free_count_ = 0;
  std::optional<std::size_t> written_;  // the slot between `begin` and `end`
};

/// The reader's side of a segment. Thread-safe after `map`. Does not allocate.
class MappedSegment {
 public:
  /// Checks and maps the segment `id` of a writer that offered `memory`. The descriptor is not
  /// kept. Errors: wrong_kind, not_sealed, wrong_size, other_memory, no_memory.
  static MemoryResult<MappedSegment> map(const FileDescriptor& descriptor, std::uint64_t id,
                                         MemoryId memory);

  std::size_t octets() const { return mapping_.octets().size(); }
  /// Checks that the reference leads to a payload now. Errors: other_segment, outside, gone.
  MemoryResult<void> check(const Reference& reference) const;
  /// Copies the payload to `out`, whose size must be the length of the reference. After an
  /// error, `out` does not contain a payload. Errors: other_segment, outside, gone.
  MemoryResult<void> copy(const Reference& reference, MutableBytes out) const;

 private:
  MappedSegment() = default;

  std::uint64_t id_ = 0;
  Mapping mapping_;
};

}  // namespace ddssec::rtps::memory
