// Passes descriptors of memory between processes, and prepares memory, in a thread of its own.
//
// Strangers may connect to the local socket of a writer's process, and a hostile writer may answer
// anything. The data that they send can hold up the thread that receives, drops or closes it. So no
// thread of the participant does any of that: it gives work to the thread here, and takes results.
// If that thread is held up, results are late or never come, and samples are sent over UDP.
#pragma once

#include <memory>
#include <vector>

#include "rtps/memory/descriptor_server.hpp"
#include "rtps/memory/sample_slots.hpp"

namespace ddssec::rtps::memory {

/// Passes work to its thread. No call blocks, except the destructor, for at most kMaxEnd. Only one
/// thread may use it.
class DescriptorPassing {
 public:
  /// The longest time that a writer's process may take to answer.
  static constexpr std::chrono::seconds kMaxRequest{3};
  /// The largest number of tasks that are not finished.
  static constexpr std::size_t kMaxWork = 64;
  static constexpr std::chrono::milliseconds kMaxEnd{200};

  /// A descriptor that was fetched.
  struct FetchedSegment {
    std::uint64_t id = 0;
    MemoryResult<MappedSegment> segment;
  };
  /// Slots that were made or wiped.
  struct PreparedSlots {
    std::uint64_t id = 0;
    MemoryResult<SampleSlots> slots;
  };

  /// Creates the local socket, without a thread. Errors: those of the local socket.
  static MemoryResult<std::unique_ptr<DescriptorPassing>> make(Random& random,
                                                               Users users = Users::own);
  ~DescriptorPassing();

  /// Starts the thread, which does the work from now on. Until then `serve` does it, for tests.
  /// Returns false if no thread could be started: then no work is accepted.
  bool start();
  /// Call it when `descriptor()` is readable, and at `deadline()`.
  void serve(MonotonicTime now);
  int descriptor() const;
  std::optional<MonotonicTime> deadline() const { return offers().next_end(); }

  /// See DescriptorServer. Further error: held_up.
  MemoryResult<DescriptorOffer> offer(const Segment& segment, Random& random, MonotonicTime now,
                                      std::string identity = {});
  OpenOffers& offers();
  const OpenOffers& offers() const;

  bool accepts_work() const;
  // Each returns the id of its result. Error: held_up, unless accepts_work().
  MemoryResult<std::uint64_t> fetch(DescriptorOffer offer);
  /// See SampleSlots::make; also no_room.
  MemoryResult<std::uint64_t> make_slots(std::uint64_t segment, std::size_t largest);
  /// Frees all slots and overwrites their contents. May be called even if work is no longer
  /// accepted.
  std::uint64_t wipe(SampleSlots slots);

  std::vector<FetchedSegment> take_fetched();
  std::vector<PreparedSlots> take_prepared();

 private:
  struct Shared;
  explicit DescriptorPassing(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}

  const std::shared_ptr<Shared> shared_;  // shared with the thread, which may outlive this object
};

}  // namespace ddssec::rtps::memory
