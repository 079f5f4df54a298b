// The samples of durable writers, in a SQLite file (PERSISTENT) or in memory (TRANSIENT): DDS 1.4,
// 2.2.3.4 and 2.2.3.5.
#pragma once

#include <deque>
#include <map>
#include <span>
#include <vector>

#include "base/ids.hpp"
#include "rtps/durability/database.hpp"
#include "rtps/durability/store_shares.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Whose samples belong together: those of one writer, before and after it was restarted.
struct StreamKey {
  std::uint32_t domain = 0;
  std::string topic, type;
  std::vector<std::string> partition = {};
  std::uint32_t ordinal = 0;  ///< among the participant's writers that are alike in all that
  bool operator==(const StreamKey&) const = default;
};

/// Names a stream in one opened store.
struct StreamId {
  std::int64_t value = 0;
  auto operator<=>(const StreamId&) const = default;
};

struct StoredChange {
  StreamId stream;
  Change change;
  /// Whose share of the store it takes (ParticipantCore::identity_of); nothing: it has no bound.
  std::optional<GuidPrefix> identity = {};
};

/// Whatever a commit wrote survives the end of the process or, for a file, of the machine; whatever
/// it did not is not there at all. One thread at a time; one process a file.
class SampleStore {
 public:
  static constexpr std::size_t kMostStreams = 1024;
  static constexpr std::size_t kMostSamples = 1 << 20;  ///< of a stream without RESOURCE_LIMITS
  static constexpr std::size_t kDefaultOctets = std::size_t{4} << 30;

  /// An empty path: in memory. A file that is missing or empty becomes a store, readable by its
  /// owner alone; another is checked: that it is ours, of this version, whole, and not in use by
  /// another process. What does not pass is left as it is. Errors: rtps_store_unusable,
  /// rtps_store_failed.
  static Result<SampleStore> open(const std::string& path,
                                  std::size_t most_octets = kDefaultOctets);
  SampleStore(SampleStore&&) noexcept = default;

  /// The stream of a writer, new or with what it held; how much is kept of it from now on `service`
  /// says. A new one is in the database from its first sample on. Errors: rtps_store_failed,
  /// rtps_store_unusable.
  Result<StreamId> stream(const StreamKey& key, const DurabilityService& service);
  /// Its writer is gone: without samples nothing of it stays. Errors: rtps_store_failed,
  /// rtps_store_unusable (then it goes when the store is opened again).
  Status close(StreamId stream);
  /// In the order in which they were stored, oldest first, each as its original writer's. Errors:
  /// rtps_store_unusable (one is not what was stored), rtps_store_failed.
  Result<std::vector<Change>> load(StreamId stream);
  /// All of them or, if it fails, none. What exceeds DURABILITY_SERVICE's limits is left out and
  /// counted; with KEEP_LAST the oldest goes instead. What exceeds the share of its identity is
  /// left out and counted, too; the end of an instance then removes it. Disposed instances go when
  /// service_cleanup_delay is over: `now` is the calendar time. Errors: rtps_store_failed,
  /// rtps_store_unusable.
  Status commit(std::span<const StoredChange> changes, Time now);

  /// Of how many writers it has samples, or will have: at most kMostStreams.
  Result<std::size_t> streams();
  /// Samples held of it.
  std::size_t size(StreamId stream) const;
  /// Changes that did not fit the limits; never reset.
  std::uint64_t left_out() const { return left_out_; }
  /// Changes that did not fit the share of their identity; never reset.
  std::uint64_t over_share() const { return over_share_; }
  std::vector<StoreShares::Refusals> take_refusals() { return shares_.take_news(); }
  const std::string& path() const { return path_; }

 private:
  struct Row {
    std::int64_t id;
    std::uint32_t octets;
    StoreShares::Account account;
  };
  using Rows = std::deque<Row>;
  struct Ended {
    std::int64_t due = 0;  ///< nanoseconds of the calendar
    KeyHash key{};
  };
  struct Stream {
    StreamKey key;
    bool has_row = false;
    DurabilityService service;
    std::map<KeyHash, Rows> instances;
    std::deque<Ended> ended;  ///< disposed instances that are still here
    std::size_t samples = 0;
  };

  SampleStore(Database database, std::string path)
      : database_(std::move(database)), path_(std::move(path)) {}
  Status prepare(std::size_t most_octets);
  Status check_origin();
  Status check_schema(std::int64_t version);
  Status create_schema();
  /// Of version 2, which said of no sample who had sent it.
  Status renew_schema();
  /// Of all streams without samples.
  Status erase_empty_streams();
  /// Nothing: not in the database.
  Result<std::optional<StreamId>> row_of(const StreamKey& key);
  /// Nothing: known neither to the database nor to this.
  Result<std::optional<StreamId>> find(const StreamKey& key);
  Status insert_row(StreamId id, const StreamKey& key);
  Status read_index(StreamId id, Stream& stream);
  Status read_shares();
  StoreShares::Account account_of(BytesView identity);
  Status add(StreamId id, Stream& stream, const StoredChange& stored, Time now);
  Status insert(StreamId id, Stream& stream, const StoredChange& stored, Time now);
  /// With KEEP_LAST, how many of an instance's rows the next one replaces.
  static std::size_t replaced(const Stream& stream, const Rows& rows);
  Result<bool> has_share(StoreShares::Account account, std::size_t octets, std::size_t freed);
  Status measure_room();
  bool has_room(const Stream& stream, const KeyHash& key) const;
  Status erase_instance(Stream& stream, const KeyHash& key);
  Status erase_row(const Row& row);
  Status clean_up(Stream& stream, std::int64_t now);
  std::unexpected<Error> damaged(std::int64_t row) const;

  Database database_;
  std::string path_;
  SqlStatement insert_, erase_;
  std::map<StreamId, Stream> streams_;
  StoreShares shares_;
  std::size_t most_pages_ = 0;
  std::size_t free_ = 0, measured_free_ = 0;  ///< octets: about, and when it was measured
  std::int64_t last_row_ = 0, last_stream_ = 0;
  std::uint64_t left_out_ = 0, over_share_ = 0;
};

}  // namespace ddssec::rtps
