// DURABILITY TRANSIENT and PERSISTENT of a DataWriter (DDS 1.4, 2.2.3.4): stores its samples where
// they outlive the writer.
#pragma once

#include <chrono>
#include <mutex>
#include <vector>

#include "base/result.hpp"
#include "rtps/durability/stored_change.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/moment.hpp"

namespace ddssec::rtps {

class DurableStore;

/// One writer's stream in a DurableStore. All calls have no effect until it is opened. The caller
/// serializes calls.
class WriterDurability {
 public:
  WriterDurability() = default;
  /// Closes the stream. After that, another writer may continue it.
  ~WriterDurability();
  WriterDurability(const WriterDurability&) = delete;
  WriterDurability& operator=(const WriterDurability&) = delete;

  /// The samples that an earlier writer left, and the time at which each of them expires; kNever if
  /// it does not.
  struct RestoredHistory {
    std::vector<Change> history;
    std::vector<MonotonicTime> expires;
  };
  /// Returns the samples that an earlier writer left in the stream. `store` must outlive this
  /// object. `lifespan` is that of the writer, whose samples live no longer. Errors: those of
  /// DurableStore::open_stream.
  Result<RestoredHistory> open(DurableStore& store, StreamKey key, const DurabilityService& service,
                               const Moment& now, Duration lifespan = kDurationInfinite);
  bool is_open() const { return store_ != nullptr; }

  /// Sets the LIFESPAN of samples that are appended from now on.
  void set_lifespan(Duration lifespan) { lifespan_ = lifespan; }
  /// Stores the change with sequence number `number` of `writer`. Never waits.
  void append(Change& change, const Guid& writer, SequenceNumber number, const Moment& now);
  /// Removes expired samples from the store. Never waits.
  void clean_up(const Moment& now);
  /// Returns the time at which clean_up is to be called next; kNever if there is nothing to remove.
  MonotonicTime next_clean_up(MonotonicTime now) const;
  /// If too much is waiting to be stored, releases `lock` and waits. Errors: those of
  /// DurableStore::status and DurableStore::wait_for_room.
  Status wait_for_room(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds timeout);
  /// Waits until everything is stored. The caller does not hold the lock. Errors: those of
  /// DurableStore::flush.
  Status flush(std::chrono::nanoseconds timeout);

 private:
  DurableStore* store_ = nullptr;
  StreamId stream_;
  Duration lifespan_ = kDurationInfinite;
};

}  // namespace ddssec::rtps
