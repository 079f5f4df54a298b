// What is stored of each stream, in memory: decides whether a change is stored, and what it
// replaces (DURABILITY_SERVICE: DDS 1.4, 2.2.3.5; LIFESPAN: 2.2.3.16; shares of identities). No
// I/O, clock or lock.
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

/// Knows of each stored sample its row, place and expiry, and judges each new one. SampleStore has
/// the content.
class SampleIndex {
 public:
  /// Limit for a stream without RESOURCE_LIMITS. Of it, one identity gets no more than is free.
  static constexpr std::size_t kMaxSamples = 1 << 20;

  /// `last_row`: the last one that the store has used.
  explicit SampleIndex(std::int64_t last_row = 0) : last_row_(last_row) {}

  /// From now on the stream holds `history`, which the shares include already, and `service`
  /// determines how much of it is kept. When a sample arrived that has a later source timestamp
  /// than `now` is not known, and it overtakes nothing. `lifespan` limits how long the samples
  /// live, besides what is stored with each. Returns when each of them expires (kNever: it does
  /// not). Removes nothing: see clean_up.
  std::vector<MonotonicTime> open(StreamId stream, const DurabilityService& service,
                                  const StoredHistory& history, const Moment& now,
                                  Duration lifespan = kDurationInfinite);
  void close(StreamId stream) { streams_.erase(stream); }

  enum class Decision : std::uint8_t {
    stored,     ///< in `row`
    ended,      ///< no row: it ends an instance, has expired, or says nothing that is stored
    left_out,   ///< above the limits of DURABILITY_SERVICE, and counted
    overtaken,  ///< it is late or was relayed, and its instance was written or ended later
    waits,      ///< above the share of its identity, in octets or in samples of the stream
  };
  struct AddResult {
    Decision decision = Decision::waits;
    std::int64_t row = 0;
    std::vector<std::int64_t> removed = {};
  };
  /// `entry.stream`, `change`, `identity`, `is_late`, `is_remembered`, `relay_order` and `lifespan`
  /// are given; sets `row`, `expiry`, `removed` and `ends`, and returns the row and `removed` as
  /// well. With KEEP_LAST it replaces the oldest of its instance. The end of an instance that has
  /// no room removes the instance. What waits or is left out changes nothing, nor does an exception
  /// (std::bad_alloc).
  AddResult add(StoredChange& entry, const Moment& now);
  /// Limit for the rows that one call of clean_up removes.
  static constexpr std::size_t kMaxRemoved = 256;
  /// Removes samples of `entry.stream` that have expired, and of disposed instances whose
  /// service_cleanup_delay is over. Sets `removed` and `ends`, and returns the former. The steps of
  /// the calendar have no effect. An exception (std::bad_alloc) changes nothing.
  std::vector<std::int64_t> clean_up(StoredChange& entry, MonotonicTime now,
                                     std::size_t max_samples = kMaxRemoved);
  /// When clean_up next has something to do. kNever: nothing is due by itself.
  MonotonicTime next_due(StreamId stream) const;

  StoreShares& shares() { return shares_; }
  /// The number of octets that are free in the store, as long as nothing is added.
  void set_free(std::size_t octets) { free_ = octets; }
  /// The number of samples that are held of the stream.
  std::size_t size(StreamId stream) const;
  /// The number of changes that did not fit the limits of DURABILITY_SERVICE; never reset.
  std::uint64_t left_out() const { return left_out_; }
  /// For tests: another limit than kMaxSamples.
  void limit_samples(std::size_t max_samples) { max_samples_ = max_samples; }

 private:
  using Account = StoreShares::Account;
  struct Row {
    std::int64_t id;
    std::uint32_t octets;
    Account account;
    Time time;  ///< of the source, at most that of arrival
    MonotonicTime expires = kNever;
    Original origin = {};
  };
  /// Where a row belongs among those of its instance: after those that were stored before. A
  /// change that was relayed too late has the `base` of the later row of its writer.
  struct Place {
    std::int64_t base = 0;  ///< a row
    SequenceNumber number;  ///< of the original writer
    auto operator<=>(const Place&) const = default;
  };
  /// Oldest first. Any of them may expire first.
  using Rows = std::map<Place, Row>;
  /// The disposed instances that have not been removed yet. Each costs the same, however many there
  /// are.
  class Ended {
   public:
    void add(const KeyHash& key, MonotonicTime due);
    void remove(const KeyHash& key);
    bool contains(const KeyHash& key) const { return by_key_.contains(key); }
    /// Those that are due at `now`, of too many the first.
    std::vector<KeyHash> due(MonotonicTime now, std::size_t max_samples) const;
    MonotonicTime next_due() const { return by_time_.empty() ? kNever : by_time_.begin()->first; }

   private:
    std::map<KeyHash, MonotonicTime> by_key_;
    std::set<std::pair<MonotonicTime, KeyHash>> by_time_;
  };
  /// The last ends of instances that left no row, by source timestamp.
  class PastEnds {
   public:
    /// Of one identity. Beyond, its oldest is forgotten.
    static constexpr std::size_t kMaxOfOne = 1024;
    /// Returns what changes.
    std::vector<StoredEnd> add(const KeyHash& key, Time time, Account account);
    /// An earlier process has added it.
    void restore(const StoredEnd& end);
    /// True if another identity ended it later.
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
  /// When a row expires, its place and its instance.
  using Expiring = std::tuple<MonotonicTime, Place, KeyHash>;
  struct Stream {
    DurabilityService service;
    std::map<KeyHash, Rows> instances;
    Ended ended;
    PastEnds past_ends;
    /// By a keeper, and something was stored: ends are remembered for the next process.
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
    MonotonicTime left{};      ///< until it expires; kNever: it does not
    std::size_t replaced = 0;  ///< rows of its instance that go then (KEEP_LAST)
  };

  Candidate candidate_of(const Stream& stream, const StoredChange& entry, const Moment& now);
  Decision decide(const Stream& stream, const StoredChange& entry,
                  const Candidate& candidate) const;
  AddResult store(Stream& stream, StoredChange& entry, const Candidate& candidate,
                  const Moment& now);
  /// The instance has ended, and its end is not stored.
  AddResult end_instance(Stream& stream, StoredChange& entry, const Candidate& candidate);
  static Account account_of(StoreShares& shares, const std::optional<GuidPrefix>& identity);
  /// With KEEP_LAST: how many of an instance's rows the next one replaces.
  static std::size_t replaced(const Stream& stream, const Rows& rows);
  static std::vector<std::int64_t> oldest(const Rows& rows, std::size_t count);
  static bool is_overtaken(const Stream& stream, const KeyHash& key, Time time, Account account);
  /// A change that was relayed is older than what is stored, and has no place before it. `place`:
  /// its place.
  static bool is_outdated(const Stream& stream, const StoredChange& entry, Time time,
                          const Place& place);
  /// The place of the row that is stored next.
  static Place place_of(const Stream& stream, const KeyHash& key, const Row& row);
  bool has_share(const Stream& stream, const KeyHash& key, Account account,
                 std::size_t octets) const;
  /// `replaced`: number of rows that go before.
  bool has_room(const Stream& stream, const KeyHash& key, std::size_t replaced) const;
  /// `ends_at`: when the disposed instance is removed. kNever: it is alive, or stays.
  void insert(Stream& stream, const KeyHash& key, const Place& place, const Row& row,
              MonotonicTime ends_at);
  void erase(Stream& stream, const KeyHash& key, const Rows::value_type& row);
  /// The instance has ended, and no row of it stays.
  static void note_end(Stream& stream, StoredChange& entry, const KeyHash& key, const Row& last);
  void erase_oldest(Stream& stream, const KeyHash& key, std::size_t count);
  void erase_instance(Stream& stream, const KeyHash& key);
  /// With the last one of its rows, the instance goes as well.
  void erase_row(Stream& stream, const KeyHash& key, const Place& place);

  std::map<StreamId, Stream> streams_;
  StoreShares shares_;
  std::size_t free_ = 0;
  std::int64_t last_row_;
  std::uint64_t left_out_ = 0;
  std::size_t max_samples_ = kMaxSamples;
};

}  // namespace ddssec::rtps
