// The samples of durable writers, in a SQLite file (PERSISTENT) or in memory (TRANSIENT): DDS 1.4,
// 2.2.3.4 and 2.2.3.5.
#pragma once

#include <map>
#include <optional>
#include <span>

#include "rtps/durability/heard_writers.hpp"
#include "rtps/durability/store_shares.hpp"

namespace ddssec::rtps {

/// Committed changes survive the end of the process or, for a file, of the machine. Changes that
/// were not committed leave no trace. May be used by one thread at a time, and a file by one
/// process.
class SampleStore {
 public:
  static constexpr std::size_t kMaxStreams = 1024;
  static constexpr std::size_t kDefaultOctets = std::size_t{4} << 30;

  /// Opens a store; an empty path means one in memory. A file that is missing or empty becomes a
  /// store that only its owner can read. Any other file is checked: it must be a store of this
  /// version, undamaged, not in use by another process, and readable only by the user of this one,
  /// as must be SQLite's files next to it. A file that fails the check is not changed. Samples that
  /// have expired at `now`, a calendar time, are removed. Errors: rtps_store_unusable,
  /// rtps_store_failed.
  static Result<SampleStore> open(const std::string& path, std::size_t max_octets = kDefaultOctets,
                                  Time now = {});
  SampleStore(SampleStore&&) noexcept = default;

  /// Returns the stream of a writer: a new one, or the existing one with its samples. A new stream
  /// is in the database from its first sample on. If there are too many streams, one that is not
  /// open and has no samples is forgotten. Errors: rtps_store_failed, rtps_store_unusable.
  Result<StreamId> stream(const StreamKey& key);
  /// Closes a stream whose writer is gone. Removes it if it has no samples, and no writer that was
  /// heard on it is remembered. Errors: rtps_store_failed, rtps_store_unusable (then it is removed
  /// when the store is opened again).
  Status close(StreamId stream);
  /// Returns the samples in the order in which they were stored, oldest first, each with its
  /// original writer. Errors: rtps_store_unusable (a sample differs from what was stored),
  /// rtps_store_failed.
  Result<StoredHistory> load(StreamId stream);
  /// Removes and stores what the changes say or, if it fails, does nothing. SampleIndex determines
  /// what they say; without a source timestamp, `now` is stored. If too many writers are
  /// remembered, those that were heard longest ago are forgotten. Errors: rtps_store_failed,
  /// rtps_store_unusable.
  Status commit(std::span<const StoredChange> changes, Time now);

  /// Adds the samples of all streams to the shares. Errors: rtps_store_failed, rtps_store_unusable.
  Status read_shares(StoreShares& shares);
  /// Returns the number of octets that are free, in the store and on its disk. Errors:
  /// rtps_store_failed, rtps_store_unusable.
  Result<std::size_t> room();
  /// Returns the number of the last row that was used.
  std::int64_t last_row() const { return last_row_; }
  /// Returns the number of streams that have samples or remembered writers, or will have: at most
  /// kMaxStreams.
  Result<std::size_t> streams();
  const std::string& path() const { return path_; }

 private:
  struct Stream {
    StreamKey key;
    bool has_row = false;
  };

  SampleStore(Database database, std::string path)
      : database_(std::move(database)), path_(std::move(path)) {}
  Status prepare(std::size_t max_octets, Time now);
  Status check_origin();
  Status check_schema(std::int64_t version);
  Status create_schema();
  /// Upgrades the schema of an earlier version.
  Status upgrade_schema(std::int64_t version);
  /// Removes expired samples of all streams. The caller holds none of them.
  Status erase_expired(Time now);
  /// Removes all streams without samples and remembered writers.
  Status erase_unused_streams();
  /// Forgets the stream without samples that was not heard on for the longest time.
  Status forget_least_used_stream();
  /// Removes a stream without samples, and the writers that were heard on it.
  Status forget(StreamId id);
  /// Returns empty if the stream is not in the database.
  Result<std::optional<StreamId>> row_of(const StreamKey& key);
  /// Returns empty if the stream is neither in the database nor in memory.
  Result<std::optional<StreamId>> find(const StreamKey& key);
  Status insert_row(StreamId id, const StreamKey& key);
  Status insert(const StoredChange& stored, Time now);
  Status write(std::span<const StoredChange> changes, Time now);
  /// Fails if there is no room on the disk for what the changes store.
  Status check_disk(std::span<const StoredChange> changes);
  /// Copies the write-ahead log into the file, and gives its room back.
  Status shorten_log();
  struct Pages {
    std::size_t used, unused;  ///< number of the pages that the file has, or will have
  };
  Result<Pages> pages();
  Status remember(std::span<const StoredChange> changes);
  std::unexpected<Error> damaged_row_error(std::int64_t row) const;

  Database database_;
  std::string path_;
  SqlStatement insert_, erase_;
  HeardWriters heard_;
  std::map<StreamId, Stream> streams_;
  std::size_t max_pages_ = 0;
  std::int64_t last_row_ = 0, last_stream_ = 0;
};

}  // namespace ddssec::rtps
