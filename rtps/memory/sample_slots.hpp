// The slots of a segment, by the samples that they contain.
#pragma once

#include <chrono>

#include "base/clock.hpp"
#include "rtps/memory/segment.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps::memory {

/// Samples come with ascending numbers. The slot of a sample is used again when no reader needs the
/// sample any longer, the oldest one first. If no slot is free, it is used again kMaxUse after it
/// was written. Then a reader that comes late finds the sample gone. Allocates only in `make`.
class SampleSlots {
 public:
  static constexpr MonotonicTime kMaxUse = std::chrono::milliseconds(200);
  /// The memory that the slots of a segment take together, unless their number would be below kMin
  /// or above kMax.
  static constexpr std::size_t kOctets = std::size_t{16} << 20;
  static constexpr std::size_t kMin = 4, kMax = 64;

  /// Returns the approximate memory that `make` takes, in octets.
  static std::size_t size_for(std::size_t largest);
  /// Creates slots for payloads of up to `largest` octets, or somewhat more. Errors: those of
  /// Segment::make.
  static MemoryResult<SampleSlots> make(std::uint64_t id, std::size_t largest);

  const Segment& segment() const { return segment_; }
  /// Frees all slots, and overwrites their contents.
  void wipe();
  /// Ends the mapping. No slot may be used afterwards.
  void unmap() { segment_.unmap(); }

  /// Returns the place for the next sample. Readers may still need the samples from `needed_from`
  /// on. Error: full.
  MemoryResult<MutableBytes> begin(SequenceNumber needed_from, MonotonicTime now);
  /// Ends the writing of the sample, which readers may then read.
  Reference end(SequenceNumber number, std::size_t length, MonotonicTime now);
  /// Ends the writing without a sample.
  void cancel() { segment_.cancel(); }

 private:
  struct UsedSlot {
    SequenceNumber number;
    MonotonicTime since{};
    Reference reference;
  };
  explicit SampleSlots(Segment segment) : segment_(std::move(segment)), used_(segment_.slots()) {}
  const UsedSlot& oldest() const { return used_[first_]; }
  void release_oldest();

  Segment segment_;
  std::vector<UsedSlot> used_;  // a ring: `count_` from `first_` on, oldest first
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace ddssec::rtps::memory
