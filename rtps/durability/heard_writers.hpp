// The table of what a keeper has heard: up to where of each writer, and which instances have ended.
#pragma once

#include <span>

#include "rtps/durability/database.hpp"
#include "rtps/durability/stored_change.hpp"

namespace ddssec::rtps {

/// Of a store of samples. The caller holds a transaction for whatever writes. Errors of all
/// functions: rtps_store_failed, rtps_store_unusable.
class HeardWriters {
 public:
  /// Limit for the entries, of all streams. In a small store they are fewer. Of too many, those
  /// that were used longest ago are forgotten.
  static constexpr std::size_t kMax = 1 << 18;

  /// `max_octets`: those of the store.
  Status open(Database& database, std::size_t max_octets);
  /// Remembers what the changes say about a stream.
  Status remember(Database& database, std::span<const StoredChange* const> changes);
  /// Returns false if an entry is damaged.
  Result<bool> load(Database& database, StreamId stream, StoredHistory& out) const;
  /// Forgets what was heard on the stream.
  Status forget(Database& database, StreamId stream);
  /// What the counters were, for a transaction that fails.
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

  SqlStatement renew_, insert_, erase_;
  Counters counters_;
  std::size_t max_ = kMax;
};

}  // namespace ddssec::rtps
