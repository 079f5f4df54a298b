// An index in memory of what is stored of each stream. It decides whether a change is stored, and
// what it replaces (DURABILITY_SERVICE: DDS 1.4, 2.2.3.5; LIFESPAN: 2.2.3.16; shares of
// identities). No I/O, clock or lock.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "rtps/durability/store_shares.hpp"
#include "rtps/durability/stored_change.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/moment.hpp"

namespace ddssec::rtps {

/// Knows the row, place and expiry of each stored sample, and judges each new one. SampleStore has
/// the content.
class SampleIndex {
 public:
  /// The limit for a stream without RESOURCE_LIMITS. One identity gets no more of it than is free.
  static constexpr std::size_t kMaxSamples = 1 << 20;

  /// `last_row` is the last one that the store has used.
  explicit SampleIndex(std::int64_t last_row = 0) : last_row_(last_row) {}

  /// Opens a stream with `history`, which the shares include already. `service` determines how much
  /// of it is kept. If a sample has a later source timestamp than `now`, its time of arrival is not
  /// known, and it overtakes nothing. `lifespan` limits how long the samples live, in addition to
  /// the limit that is stored with each. Returns when each of them expires (kNever: it does not).
  /// Removes nothing: see clean_up.
  std::vector<MonotonicTime> open(StreamId stream, const DurabilityService& service,
                                  const StoredHistory& history, const Moment& now,
                                  Duration lifespan = kDurationInfinite);
  void close(StreamId stream) { streams_.erase(stream); }

  enum class Decision : std::uint8_t {
    stored,     ///< it is stored in `row`
    ended,      ///< it has no row: it ends an instance, has expired, or has nothing to store
    left_out,   ///< it is above the limits of DURABILITY_SERVICE, and counted
    overtaken,  ///< it is late or was relayed, and its instance was written or ended later
    waits,      ///< it is above its identity's share, in octets or in samples of the stream
  };
  struct AddResult {
    Decision decision = Decision::waits;
    std::int64_t row = 0;
    std::vector<std::int64_t> removed = {};
  };
  /// Decides about a change. `entry.stream`, `change`, `identity`, `is_late`, `is_remembered`,
  /// `relay_order` and `lifespan` are given. Sets `row`, `expiry`, `removed` and `ends`, and also
  /// returns the row and `removed`. With KEEP_LAST the change replaces the oldest of its instance.
  /// If the end of an instance has no room, the instance is removed. A change that waits or is left
  /// out has no effect, nor has an exception (std::bad_alloc).
  AddResult add(StoredChange& entry, const Moment& now);
  /// The largest number of rows that one call of clean_up removes.
  static constexpr std::size_t kMaxRemoved = 256;
  /// Removes samples of `entry.stream` that have expired, and samples of disposed instances whose
  /// service_cleanup_delay is over. Sets `removed` and `ends`, and returns `removed`. Steps of the
  /// calendar clock have no effect. An exception (std::bad_alloc) changes nothing.
  std::vector<std::int64_t> clean_up(StoredChange& entry, MonotonicTime now,
                                     std::size_t max_samples = kMaxRemoved);
  /// Returns the time at which clean_up has work next; kNever if nothing is due by itself.
  MonotonicTime next_due(StreamId stream) const;

  StoreShares& shares() { return shares_; }
  /// Sets the number of octets that are free in the store, as long as nothing is added.
  void set_free(std::size_t octets) { free_ = octets; }
  /// Returns the number of samples that are held of the stream.
  std::size_t size(StreamId stream) const;
  /// Returns the number of changes that did not fit the limits of DURABILITY_SERVICE; never reset.
  std::uint64_t left_out() const { return left_out_; }

 private:
  friend struct SampleLimit;  // tests/support/sample_limit.hpp

  using Account = StoreShares::Account;
  struct Row {
    std::int64_t id;
    std::uint32_t octets;
    Account account;
    Time time;  ///< source time, at most the time of arrival
    MonotonicTime expires = kNever;
    OriginalWriterInfo origin = {};
  };
  /// The place of a row among those of its instance: after those that were stored before. A change
  /// that was relayed too late has the `base` of the later row of its writer.
  struct Place {
    std::int64_t base = 0;  ///< a row number
    SequenceNumber number;  ///< number that the original writer gave it
    auto operator<=>(const Place&) const = default;
  };
  /// The rows of an instance, oldest first. Any of them may expire first.
  using Rows = std::map<Place, Row>;
  /// The disposed instances that have not been removed yet. The cost of each does not depend on
  /// their number.
  class DisposedInstances {
   public:
    void add(const KeyHash& key, MonotonicTime due);
    void remove(const KeyHash& key);
    bool contains(const KeyHash& key) const { return by_key_.contains(key); }
    /// Returns the instances that are due at `now`; the first ones if there are too many.
    std::vector<KeyHash> due(MonotonicTime now, std::size_t max_samples) const;
    MonotonicTime next_due() const { return by_time_.empty() ? kNever : by_time_.begin()->first; }

   private:
    std::map<KeyHash, MonotonicTime> by_key_;
    std::set<std::pair<MonotonicTime, KeyHash>> by_time_;
  };
  /// The last ends of instances that left no row, by source timestamp.
  class EndedInstanceLog {
   public:
    /// The limit for one identity. If it has more, its oldest is forgotten.
    static constexpr std::size_t kMaxOfOne = 1024;
    /// Adds an end. Returns the entries that change.
    std::vector<StoredEnd> add(const KeyHash& key, Time time, Account account);
    /// Restores an end that an earlier process has added.
    void restore(const StoredEnd& end);
    /// True if another identity ended the instance later.
    bool has_later(const KeyHash& key, Time time, Account account) const;
    bool has_later(const KeyHash& key, Time time) const;

   private:
    struct End {
      Time time;
      Account account;
    };
    using Digest = decltype(StoredEnd::instance);
    static Digest digest_of(const KeyHash& key);
    const End* find(const KeyHash& key) const;

    std::map<Digest, End> ends_;
    std::map<Account, std::deque<Digest>> by_account_;
  };
  /// The time at which a row expires, its place, and its instance.
  using Expiring = std::tuple<MonotonicTime, Place, KeyHash>;
  struct Stream {
    DurabilityService service;
    std::map<KeyHash, Rows> instances;
    DisposedInstances ended;
    EndedInstanceLog ended_instances;
    /// True if a keeper uses the stream and something was stored: ends are remembered for the next
    /// process.
    bool is_kept = false;
    std::set<Expiring> expiring;
    std::size_t samples = 0;
    std::map<Account, std::size_t> samples_of;
  };

  /// A change as it would be stored.
  struct Candidate {
    KeyHash key;
    Row row;
    Place place;
    MonotonicTime left{};      ///< time until it expires; kNever if it does not
    std::size_t replaced = 0;  ///< rows of its instance that it replaces (KEEP_LAST)
  };

  Candidate candidate_of(const Stream& stream, const StoredChange& entry, const Moment& now);
  Decision decide(const Stream& stream, const StoredChange& entry,
                  const Candidate& candidate) const;
  AddResult store(Stream& stream, StoredChange& entry, const Candidate& candidate,
                  const Moment& now);
  /// Handles an end that is not stored itself.
  AddResult end_instance(Stream& stream, StoredChange& entry, const Candidate& candidate);
  static Account account_of(StoreShares& shares, const std::optional<GuidPrefix>& identity);
  /// Returns the number of an instance's rows that the next one replaces (KEEP_LAST).
  static std::size_t replaced(const Stream& stream, const Rows& rows);
  static std::vector<std::int64_t> oldest(const Rows& rows, std::size_t count);
  static bool is_overtaken(const Stream& stream, const KeyHash& key, Time time, Account account);
  /// True if a relayed change is older than what is stored, and has no place before it. `place` is
  /// its place.
  static bool is_outdated(const Stream& stream, const StoredChange& entry, Time time,
                          const Place& place);
  /// Returns the place of the row that is stored next.
  static Place place_of(const Stream& stream, const KeyHash& key, const Row& row);
  bool has_share(const Stream& stream, const KeyHash& key, Account account,
                 std::size_t octets) const;
  /// True if there is room after `replaced` rows have been removed.
  bool has_room(const Stream& stream, const KeyHash& key, std::size_t replaced) const;
  /// Inserts a row. `ends_at` is the time at which the disposed instance is removed; kNever if it
  /// is alive, or is not removed.
  void insert(Stream& stream, const KeyHash& key, const Place& place, const Row& row,
              MonotonicTime ends_at);
  void erase(Stream& stream, const KeyHash& key, const Rows::value_type& row);
  /// Notes that the instance has ended and that no row of it is left.
  static void note_end(Stream& stream, StoredChange& entry, const KeyHash& key, const Row& last);
  void erase_oldest(Stream& stream, const KeyHash& key, std::size_t count);
  void erase_instance(Stream& stream, const KeyHash& key);
  /// Erases a row. With the last one, the instance is removed as well.
  void erase_row(Stream& stream, const KeyHash& key, const Place& place);

  std::map<StreamId, Stream> streams_;
  StoreShares shares_;
  std::size_t free_ = 0;
  std::int64_t last_row_;
  std::uint64_t left_out_ = 0;
  std::size_t max_samples_ = kMaxSamples;
};

}  // namespace ddssec::rtps
