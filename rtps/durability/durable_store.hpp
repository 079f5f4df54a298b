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
/// write-ahead log and synchronous=FULL: what flush has waited for survives a power failure.
/// Thread-safe.
class DurableStore {
 public:
  /// Limits for changes that are appended but not committed. Above them, writers should wait.
  static constexpr std::size_t kMaxPending = 65536;
  static constexpr std::size_t kMaxPendingOctets = std::size_t{16} << 20;
  /// The limit for one identity, whose changes wait above it. One change is always taken.
  static constexpr std::size_t kMaxPendingOctetsOfOne = std::size_t{4} << 20;

  /// `events` must outlive the store. Samples that have expired at `now`, a calendar time, are
  /// removed. Errors: those of SampleStore::open, rtps_thread_failed.
  static Result<std::unique_ptr<DurableStore>> open(
      const std::string& path, EventSink& events,
      std::size_t max_octets = SampleStore::kDefaultOctets, Time now = {});
  /// Commits what was appended, if possible.
  ~DurableStore();

  struct Opened {
    StreamId id;
    std::vector<Change> history;
    std::vector<std::int64_t> rows;  ///< identify the samples of `history`
    std::vector<HeardWriter> heard = {};
    std::vector<MonotonicTime> expires = {};  ///< when each of `history` does; kNever: it does not
  };
  /// Opens the first stream of `key` that no other writer has open; its ordinal is chosen here.
  /// A stream to which nothing is appended that is not committed can be opened on a full disk.
  /// Source timestamps of stored samples that are later than `now` overtake nothing. `lifespan`
  /// limits how long the samples live, besides what is stored with each; those that have expired
  /// are removed. Errors: those of SampleStore, and those of flush.
  Result<Opened> open_stream(StreamKey key, const DurabilityService& service, const Moment& now,
                             Duration lifespan = kDurationInfinite);
  /// Once everything that was appended to the stream is committed, a stream without samples is
  /// removed.
  void close_stream(StreamId stream);

  struct Appended {
    SampleIndex::AddResult outcome;
    std::uint64_t number = 0;  ///< committed() reaches it when this is stored
    /// It waits although nothing else of its identity is being stored: it may wait for long.
    bool has_no_share = false;
  };
  /// Never waits for a disk. A change with the decision `waits` was not appended: try again
  /// later. Call clean_up before it, so that samples that have expired use no room.
  Appended append(StoredChange change, const Moment& now);
  void append(StreamId stream, const Change& change, const Moment& now) {
    append({.stream = stream, .change = change}, now);
  }
  /// A sample of the identity has no room for another reason. It is counted and reported as those
  /// are that wait for room in the store.
  void refuse(const GuidPrefix& identity);
  /// See SampleIndex::clean_up. Returns the rows that go: not all at once, if they are many.
  std::vector<std::int64_t> clean_up(StreamId stream, const Moment& now);
  /// See SampleIndex::next_due.
  MonotonicTime next_due(StreamId stream) const;
  /// The number of appended changes that are stored, in the order of append.
  std::uint64_t committed() const;
  /// The number of appended changes that are not stored yet.
  std::uint64_t pending() const;
  /// The number of changes that were left out because of the limits of DURABILITY_SERVICE; never
  /// reset.
  std::uint64_t left_out() const;
  /// True if the queue has reached its limit.
  bool is_behind() const;
  /// The result of the last group. An error lasts until a group is committed again.
  Status status() const;
  /// Waits until everything that was appended before is committed. Errors: rtps_timeout,
  /// out_of_memory, those of SampleStore::commit.
  Status flush(std::chrono::nanoseconds timeout);
  /// Waits until the queue is shorter. Errors: as for flush.
  Status wait_for_room(std::chrono::nanoseconds timeout);

  /// True if it holds no stream. Errors: those of SampleStore, rtps_timeout.
  Result<bool> is_empty();
  const std::string& path() const { return store_.path(); }

  /// The number of groups that were committed; never reset.
  std::uint64_t groups() const;

 private:
  DurableStore(SampleStore store, EventSink& events);
  Status start();
  void run();
  Status write(std::span<const StoredChange> group, Time now);
  /// What clean_up removes, for a group that failed: it goes first, because the group may need its
  /// room. What it removes of the group itself is not stored any more.
  std::vector<StoredChange> removals_before(std::vector<StoredChange>& group) const noexcept;
  /// The caller holds the mutex.
  std::vector<std::int64_t> clean_up(StreamId stream, const Moment& now, std::size_t max_samples);
  void commit(std::unique_lock<std::mutex>& held);
  /// False: the identity has enough that is not committed yet.
  bool may_append(const GuidPrefix& identity, std::size_t octets) const;
  /// Counts what was pushed to pending_. The caller holds the mutex, as for set_free.
  std::uint64_t count_pending(Time now);
  void set_free();
  std::optional<std::size_t> room_now() noexcept;
  void report(const Error* failure, std::uint64_t beyond_limits,
              const std::vector<StoreShares::Refusals>& refusals) noexcept;
  /// `after`: the change that must be committed before.
  Result<Opened> load(StreamId id, const DurabilityService& service, std::uint64_t after,
                      const Moment& now, Duration lifespan);
  /// The caller holds the store's mutex.
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
  std::vector<StoredChange> failed_;  ///< a group that is committed again, before later ones
  std::size_t octets_ = 0, failed_octets_ = 0;
  std::map<GuidPrefix, std::size_t> octets_of_;  ///< of both, by identity
  Time now_{};
  std::uint64_t appended_ = 0, committed_ = 0, groups_ = 0;
  std::uint64_t left_out_ = 0;  ///< that an event has named
  Status status_;
  SampleIndex index_;
  std::size_t room_ = 0;  ///< octets that were free after the last commit
  MonotonicTime look_at_room_at_{};
  bool looks_at_room_ = false;
  std::set<StreamId> open_;
  std::map<StreamId, std::uint64_t> last_;  ///< the number of the last change appended to each
  std::set<StreamId> closed_;               ///< not open any more, and not forgotten yet
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
