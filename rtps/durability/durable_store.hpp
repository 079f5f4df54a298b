// A store with a thread of its own that commits in groups: a writing thread never waits for a disk.
#pragma once

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "base/event.hpp"
#include "rtps/durability/sample_store.hpp"

namespace ddssec::rtps {

/// What is appended while one group is written becomes the next group. Durability mode of a file:
/// write-ahead log, synchronous=FULL: what flush has waited for survives a power cut.
class DurableStore {
 public:
  /// Appended and not yet committed: writers should wait from here on.
  static constexpr std::size_t kMostPending = 65536;
  static constexpr std::size_t kMostPendingOctets = std::size_t{16} << 20;

  /// Errors: those of SampleStore::open.
  static Result<std::unique_ptr<DurableStore>> open(
      const std::string& path, EventSink& events,
      std::size_t most_octets = SampleStore::kDefaultOctets);
  /// Commits what is there, if it can.
  ~DurableStore();

  struct Opened {
    StreamId id;
    std::vector<Change> history;
  };
  /// Of a new writer: the first stream of `key` that no other writer has open; its ordinal is
  /// chosen here. Errors: those of SampleStore.
  Result<Opened> open_stream(StreamKey key, const DurabilityService& service);
  /// Once all that was appended to it is committed, nothing stays of a stream without samples.
  void close_stream(StreamId stream);

  /// Never waits. Returns a number that committed() reaches when the change is stored, or left out.
  /// `identity`: see StoredChange.
  std::uint64_t append(StreamId stream, const Change& change, Time now,
                       const std::optional<GuidPrefix>& identity = {});
  /// How many of all that was appended is stored, in the order of append.
  std::uint64_t committed() const;
  /// How many are not.
  std::uint64_t pending() const;
  /// How many were left out for DURABILITY_SERVICE's limits or the share of an identity; never
  /// reset.
  std::uint64_t left_out() const;
  /// True: append would make the queue longer than it may be.
  bool is_behind() const;
  /// Of the last group; an error lasts until a group is committed again.
  Status status() const;
  /// Waits until all that was appended before is committed. Errors: rtps_timeout, those of
  /// SampleStore::commit.
  Status flush(std::chrono::nanoseconds most);
  /// Waits for the queue to become shorter. Errors: as flush.
  Status wait_for_room(std::chrono::nanoseconds most);

  /// Groups that were committed; never reset.
  std::uint64_t groups() const;

 private:
  DurableStore(SampleStore store, EventSink& events);
  void run();
  void commit(std::unique_lock<std::mutex>& held);
  void report(std::uint64_t beyond_limits, const std::vector<StoreShares::Refusals>& refusals);
  /// With the store's mutex.
  void forget_closed();
  bool over() const { return pending_.size() >= kMostPending || octets_ >= kMostPendingOctets; }
  template <class Ready>
  Status wait(std::chrono::nanoseconds most, Ready ready);

  mutable std::mutex mutex_;  ///< of everything but the store
  std::mutex store_mutex_;    ///< of the store; taken first
  std::condition_variable work_, done_;
  SampleStore store_;
  EventSink& events_;
  std::vector<StoredChange> pending_;
  std::size_t octets_ = 0;
  Time now_{};
  std::uint64_t appended_ = 0, committed_ = 0, groups_ = 0;
  std::uint64_t beyond_limits_ = 0, left_out_ = 0;
  Status status_;
  std::set<StreamId> open_;
  std::map<StreamId, std::uint64_t> closed_;  ///< with what must be committed before
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
