// A store with its own thread that commits in groups, so that a writing thread never waits for a
// disk.
#pragma once

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "base/event.hpp"
#include "rtps/durability/sample_index.hpp"
#include "rtps/durability/sample_store.hpp"

namespace ddssec::rtps {

/// Changes that are appended while a group is written form the next group. A file uses a
/// write-ahead log and synchronous=FULL: changes for which flush has waited survive a power
/// failure. Thread-safe.
class DurableStore {
 public:
  /// Limits for changes that are appended but not committed. Above them, writers should wait.
  static constexpr std::size_t kMaxPending = 65536;
  static constexpr std::size_t kMaxPendingOctets = std::size_t{16} << 20;
  /// The limit for one identity, whose further changes have to wait. One change is always accepted.
  /// Each change, each row that it removes and each entry of an ended instance count
  /// kOctetsOfChange octets besides the payload, so that one identity has at most a quarter of
  /// kMaxPending changes.
  static constexpr std::size_t kMaxPendingOctetsOfOne = std::size_t{4} << 20;
  static constexpr std::size_t kOctetsOfChange = kMaxPendingOctetsOfOne / (kMaxPending / 4);

  /// Opens a store. `events` must outlive it. Samples that have expired at `now`, a calendar time,
  /// are removed. Errors: those of SampleStore::open, rtps_thread_failed.
  static Result<std::unique_ptr<DurableStore>> open(
      const std::string& path, EventSink& events,
      std::size_t max_octets = SampleStore::kDefaultOctets, Time now = {});
  /// Commits the changes that were appended, if possible.
  ~DurableStore();

  struct OpenedStream {
    StreamId id;
    std::vector<Change> history;
    std::vector<std::int64_t> rows;  ///< the rows of the samples in `history`
    std::vector<HeardWriter> heard = {};
    /// The time when each of `history` expires; kNever if it does not.
    std::vector<MonotonicTime> expires = {};
  };
  /// Opens the first stream of `key` that no other writer has open; its ordinal is chosen here. A
  /// stream whose changes are all committed can be opened on a full disk. Source timestamps of
  /// stored samples that are later than `now` overtake nothing. `lifespan` limits how long the
  /// samples live, in addition to the limit that is stored with each; those that have expired are
  /// removed. Errors: those of SampleStore, and those of flush.
  Result<OpenedStream> open_stream(StreamKey key, const DurabilityService& service,
                                   const Moment& now, Duration lifespan = kDurationInfinite);
  /// Closes the stream. Once everything that was appended to it is committed, it is removed if it
  /// has no samples.
  void close_stream(StreamId stream);

  struct AppendReport {
    SampleIndex::AddResult outcome;
    std::uint64_t number = 0;  ///< committed() reaches this number when the change is stored
    /// True if the change waits although nothing else of its identity is being stored: it may wait
    /// for long.
    bool has_no_share = false;
  };
  /// Appends a change. Never waits for a disk. A change with the decision `waits` was not appended:
  /// try again later. Call clean_up before it, so that samples that have expired use no room.
  AppendReport append(StoredChange change, const Moment& now);
  void append(StreamId stream, const Change& change, const Moment& now) {
    append({.stream = stream, .change = change}, now);
  }
  /// Counts and reports a sample of the identity that has no room for another reason, like those
  /// that wait for room in the store.
  void refuse(const GuidPrefix& identity);
  /// See SampleIndex::clean_up. Returns the rows that are removed. If there are many, it removes
  /// only some of them.
  std::vector<std::int64_t> clean_up(StreamId stream, const Moment& now);
  /// See SampleIndex::next_due.
  MonotonicTime next_due(StreamId stream) const;
  /// Returns the number of appended changes that are stored, in the order of append.
  std::uint64_t committed() const;
  /// Returns the number of appended changes that are not stored yet.
  std::uint64_t pending() const;
  /// Returns the number of changes that were left out because of the limits of DURABILITY_SERVICE;
  /// never reset.
  std::uint64_t left_out() const;
  /// True if the queue has reached its limit.
  bool is_behind() const;
  /// Returns the result of the last group. An error lasts until a group is committed again.
  Status status() const;
  /// Waits until everything that was appended before is committed. Errors: rtps_timeout,
  /// out_of_memory, those of SampleStore::commit.
  Status flush(std::chrono::nanoseconds timeout);
  /// Waits until the queue is shorter. Errors: those of flush.
  Status wait_for_room(std::chrono::nanoseconds timeout);

  /// True if the store has no stream. Errors: those of SampleStore, rtps_timeout.
  Result<bool> is_empty();
  const std::string& path() const { return store_.path(); }

  /// Returns the number of groups that were committed; never reset.
  std::uint64_t groups() const;

 private:
  DurableStore(SampleStore store, EventSink& events);
  Status start();
  void run();
  Status write(std::span<const StoredChange> group, Time now);
  /// Returns what clean_up removes, for a group that failed. It is removed first, because the group
  /// may need its room. Removed changes of the group itself are not stored any more.
  std::vector<StoredChange> removals_before(std::vector<StoredChange>& group) const noexcept;
  /// Does the work of clean_up. The caller holds the mutex.
  std::vector<std::int64_t> clean_up(StreamId stream, const Moment& now, std::size_t max_samples);
  void commit(std::unique_lock<std::mutex>& held);
  /// Returns false if the identity has enough changes that are not committed yet. `octets` is the
  /// size of the payload.
  bool may_append(const GuidPrefix& identity, std::size_t octets) const;
  /// Counts the change that was pushed to pending_. The caller holds the mutex, as for set_free.
  std::uint64_t count_pending(Time now);
  void set_free();
  std::optional<std::size_t> room_now() noexcept;
  void report(const Error* failure, std::uint64_t beyond_limits,
              const std::vector<StoreShares::Refusals>& refusals) noexcept;
  /// Loads a stream. `after` is the change that must be committed before.
  Result<OpenedStream> load(StreamId id, const DurabilityService& service, std::uint64_t after,
                            const Moment& now, Duration lifespan);
  /// Removes closed streams without samples. The caller holds the store's mutex.
  void forget_closed();
  bool over() const {
    return pending_.size() + failed_.size() >= kMaxPending ||
           octets_ + failed_octets_ >= kMaxPendingOctets;
  }
  template <class Ready>
  Status wait(std::chrono::nanoseconds timeout, Ready ready);

  mutable std::mutex mutex_;      ///< protects everything but store_
  std::timed_mutex store_mutex_;  ///< protects store_; locked first
  std::condition_variable work_, done_;
  SampleStore store_;
  EventSink& events_;
  std::vector<StoredChange> pending_;
  /// A group that failed and is committed again, before later ones.
  std::vector<StoredChange> failed_;
  std::size_t octets_ = 0, failed_octets_ = 0;
  std::map<GuidPrefix, std::size_t> octets_of_;  ///< octets of both, by identity
  Time now_{};
  std::uint64_t appended_ = 0, committed_ = 0, groups_ = 0;
  std::uint64_t left_out_ = 0;  ///< the number that an event has reported
  Status status_;
  SampleIndex index_;
  std::size_t room_ = 0;  ///< octets that were free after the last commit
  MonotonicTime look_at_room_at_{};
  bool looks_at_room_ = false;
  std::set<StreamId> open_;
  std::map<StreamId, std::uint64_t> last_;  ///< the number of the last change appended to each
  std::set<StreamId> closed_;               ///< streams that are closed and not forgotten yet
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
