// The table of what a keeper has heard: up to which change of each writer, and which instances have
// ended.
#pragma once

#include <span>

#include "rtps/durability/database.hpp"
#include "rtps/durability/stored_change.hpp"

namespace ddssec::rtps {

/// The table of one store of samples. The caller holds a transaction around each function that
/// writes. Errors of all functions: rtps_store_failed, rtps_store_unusable.
class HeardWriters {
 public:
  /// The largest number of entries, for all streams together. A small store has fewer. If there are
  /// too many, the streams with the most entries forget those that were used longest ago. So the
  /// writers of one topic displace no entry of a topic with fewer of them.
  static constexpr std::size_t kMax = 1 << 18;

  /// Opens the table. `max_octets` is the size limit of the store.
  Status open(Database& database, std::size_t max_octets);
  /// Remembers what the changes say about a stream.
  Status remember(Database& database, std::span<const StoredChange* const> changes);
  /// Returns false if an entry is damaged.
  Result<bool> load(Database& database, StreamId stream, StoredHistory& out) const;
  /// Forgets what was heard on the stream.
  Status forget(Database& database, StreamId stream);
  /// The counters, so that they can be restored if a transaction fails.
  struct Counters {
    std::size_t entries = 0;
    std::int64_t last_use = 0;
  };
  const Counters& counters() const { return counters_; }
  void restore(const Counters& counters) { counters_ = counters; }

 private:
  Status remember(Database& database, StreamId stream, const HeardWriter& heard);
  Status remember(Database& database, StreamId stream, const StoredEnd& end);
  Status forget_longest_unused(Database& database);
  /// Forgets the entries of a stream that were used longest ago.
  Status forget_longest_unused(Database& database, StreamId stream, std::size_t count);

  SqlStatement renew_, insert_, erase_;
  Counters counters_;
  std::size_t max_ = kMax;
};

}  // namespace ddssec::rtps
