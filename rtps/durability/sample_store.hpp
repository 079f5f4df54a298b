// The samples of durable writers, in a SQLite file (PERSISTENT) or in memory (TRANSIENT): DDS 1.4,
// 2.2.3.4 and 2.2.3.5.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "base/ids.hpp"
#include "rtps/durability/database.hpp"
#include "rtps/durability/store_shares.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Identifies samples that belong together: those of one writer, before and after it was restarted.
struct StreamKey {
  std::uint32_t domain = 0;
  std::string topic, type;
  std::vector<std::string> partition = {};
  /// Whatever else determines which readers may get the samples, such as the domain tag.
  std::vector<std::string> scope = {};
  /// Distinguishes writers of the participant for which all other members are equal.
  std::uint32_t ordinal = 0;
  bool operator==(const StreamKey&) const = default;
};

/// Identifies a stream in one opened store.
struct StreamId {
  std::int64_t value = 0;
  auto operator<=>(const StreamId&) const = default;
};

struct StoredChange {
  StreamId stream;
  Change change;
  /// The identity whose share of the store it uses (ParticipantCore::identity_of). Empty: no limit
  /// applies.
  std::optional<GuidPrefix> identity = {};
  bool was_refused = false;  ///< a commit has refused it before
};

/// Something that a commit did to a stream.
struct StoreEffect {
  StreamId stream;
  std::int64_t row = 0;  ///< identifies a sample
  /// The change that the row holds now, by its place among all that were committed (from 1).
  /// 0: the row was removed.
  std::uint64_t stored = 0;
  /// There is no row: `stored` did not fit the share of its identity. It can be committed again
  /// when the identity is no longer crowded.
  bool is_refused = false;
  GuidPrefix identity = {};  ///< of a refused change
};

/// The samples of a stream, and the rows that hold them.
struct StoredHistory {
  std::vector<Change> changes;
  std::vector<std::int64_t> rows;
};

/// Committed changes survive the end of the process or, for a file, of the machine. Changes that
/// were not committed leave no trace. One thread at a time; one process for each file.
class SampleStore {
 public:
  static constexpr std::size_t kMostStreams = 1024;
  /// Limit for a stream without RESOURCE_LIMITS. Of it, one identity gets no more than is free.
  static constexpr std::size_t kMostSamples = 1 << 20;
  static constexpr std::size_t kDefaultOctets = std::size_t{4} << 30;

  /// An empty path opens a store in memory. A file that is missing or empty becomes a store that
  /// only its owner can read. Any other file is checked: it must be a store of this version,
  /// undamaged, not in use by another process, and readable only by the user of this one, as must
  /// be SQLite's files next to it. A file that fails the check is not changed.
  /// Errors: rtps_store_unusable, rtps_store_failed.
  static Result<SampleStore> open(const std::string& path,
                                  std::size_t most_octets = kDefaultOctets);
  SampleStore(SampleStore&&) noexcept = default;

  /// Returns the stream of a writer: a new one, or the existing one with its samples. From now on
  /// `service` determines how much of it is kept. A new stream is in the database from its first
  /// sample on. Errors: rtps_store_failed, rtps_store_unusable.
  Result<StreamId> stream(const StreamKey& key, const DurabilityService& service);
  /// The stream's writer is gone: removes the stream if it has no samples. Errors:
  /// rtps_store_failed, rtps_store_unusable (then it is removed when the store is opened again).
  Status close(StreamId stream);
  /// Returns the samples in the order in which they were stored, oldest first, each with its
  /// original writer. Errors: rtps_store_unusable (a sample differs from what was stored),
  /// rtps_store_failed.
  Result<StoredHistory> load(StreamId stream);
  /// Stores all changes or, if it fails, none. Exceptions:
  /// - A change above the limits of DURABILITY_SERVICE is left out and counted. With KEEP_LAST the
  ///   oldest one is removed instead.
  /// - A change above the share of its identity, in octets or in samples of the stream, is left out
  ///   and counted. If it is the end of an instance, the instance is removed.
  /// Disposed instances are removed after service_cleanup_delay; `now` is the calendar time.
  /// Errors: rtps_store_failed, rtps_store_unusable.
  Status commit(std::span<const StoredChange> changes, Time now);

  /// From now on, what commits do to the stream is noted, until the stream is closed.
  void watch(StreamId stream);
  /// What the last commits did to watched streams, in the order in which it happened. Must be taken
  /// before the next commit.
  std::vector<StoreEffect> take_effects() { return std::exchange(effects_, {}); }
  /// For tests: another limit than kMostSamples.
  void limit_samples(std::size_t most) { most_samples_ = most; }

  /// The number of writers that have samples in it, or will have: at most kMostStreams.
  Result<std::size_t> streams();
  /// The number of samples that are held of the stream.
  std::size_t size(StreamId stream) const;
  /// The number of changes that did not fit the limits; never reset.
  std::uint64_t left_out() const { return left_out_; }
  StoreShares& shares() { return shares_; }
  const std::string& path() const { return path_; }

 private:
  struct Row {
    std::int64_t id;
    std::uint32_t octets;
    StoreShares::Account account;
  };
  using Rows = std::deque<Row>;
  /// The disposed instances that have not been removed yet. Each costs the same, however many there
  /// are.
  class Ended {
   public:
    /// `due`: calendar time in nanoseconds.
    void add(const KeyHash& key, std::int64_t due);
    void remove(const KeyHash& key);
    void clear();
    /// The next one that is due at `now`.
    std::optional<KeyHash> due(std::int64_t now) const;

   private:
    std::map<KeyHash, std::int64_t> by_key_;
    std::set<std::pair<std::int64_t, KeyHash>> by_time_;
  };
  struct Stream {
    StreamKey key;
    bool has_row = false;
    DurabilityService service;
    std::map<KeyHash, Rows> instances;
    Ended ended;
    std::size_t samples = 0;
    std::map<StoreShares::Account, std::size_t> samples_of;  ///< without those of kNone
    bool watched = false;

    void count(const Row& row) {
      ++samples;
      if (row.account != StoreShares::kNone) ++samples_of[row.account];
    }
  };

  SampleStore(Database database, std::string path)
      : database_(std::move(database)), path_(std::move(path)) {}
  Status prepare(std::size_t most_octets);
  Status check_origin();
  Status check_schema(std::int64_t version);
  Status create_schema();
  /// Upgrades the schema of version 2, which did not store the sender of a sample.
  Status renew_schema();
  /// Removes all streams without samples.
  Status erase_empty_streams();
  /// Empty: not in the database.
  Result<std::optional<StreamId>> row_of(const StreamKey& key);
  /// Empty: neither in the database nor in memory.
  Result<std::optional<StreamId>> find(const StreamKey& key);
  Status insert_row(StreamId id, const StreamKey& key);
  Status read_index(StreamId id, Stream& stream);
  Status read_shares();
  StoreShares::Account account_of(BytesView identity);
  Status add(StreamId id, Stream& stream, const StoredChange& stored, Time now);
  void refuse(StreamId id, const Stream& stream, StoreShares::Account account,
              const Change& change);
  void look_for_room();
  Status insert(StreamId id, Stream& stream, const StoredChange& stored, Time now);
  /// With KEEP_LAST: how many of an instance's rows the next one replaces.
  static std::size_t replaced(const Stream& stream, const Rows& rows);
  Result<bool> has_share(StoreShares::Account account, std::size_t octets, std::size_t freed);
  /// The same for the samples of a stream. `freed`: how many of its own the next one replaces.
  bool has_place(const Stream& stream, StoreShares::Account account, std::size_t freed) const;
  Status measure_room();
  bool has_room(const Stream& stream, const KeyHash& key) const;
  Status erase_instance(StreamId id, Stream& stream, const KeyHash& key);
  Status erase_row(StreamId id, Stream& stream, const Row& row);
  Status clean_up(StreamId id, Stream& stream, std::int64_t now);
  std::unexpected<Error> damaged(std::int64_t row) const;

  Database database_;
  std::string path_;
  SqlStatement insert_, erase_;
  std::map<StreamId, Stream> streams_;
  StoreShares shares_;
  std::size_t most_pages_ = 0;
  /// Octets: the current estimate, and the value when it was last measured.
  std::size_t free_ = 0, measured_free_ = 0;
  std::int64_t last_row_ = 0, last_stream_ = 0;
  std::uint64_t left_out_ = 0;
  std::size_t most_samples_ = kMostSamples;
  std::uint64_t committed_ = 0;  ///< number of changes, including those that were left out
  std::uint64_t place_ = 0;      ///< of the change that is being committed
  bool is_stale_ = false;        ///< what is held in memory may differ from the database
  std::vector<StoreEffect> effects_;
};

}  // namespace ddssec::rtps
