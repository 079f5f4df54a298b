// DURABILITY TRANSIENT and PERSISTENT of a DataWriter (DDS 1.4, 2.2.3.4): stores its samples where
// they outlive the writer.
#pragma once

#include <chrono>
#include <mutex>
#include <vector>

#include "base/result.hpp"
#include "rtps/durability/stored_change.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

class DurableStore;

/// One writer's stream in a DurableStore. All calls have no effect until it is opened. The caller
/// serializes calls.
class WriterDurability {
 public:
  WriterDurability() = default;
  /// From now on another writer may continue the stream.
  ~WriterDurability();
  WriterDurability(const WriterDurability&) = delete;
  WriterDurability& operator=(const WriterDurability&) = delete;

  /// Returns the samples that an earlier writer left in the stream. `store` must outlive this
  /// object. `now`: calendar time. Errors: those of DurableStore::open_stream.
  Result<std::vector<Change>> open(DurableStore& store, StreamKey key,
                                   const DurabilityService& service, Time now);
  bool is_open() const { return store_ != nullptr; }

  /// Stores the change with sequence number `number` of `writer`. Never waits.
  void append(Change& change, const Guid& writer, SequenceNumber number, Time now);
  /// If too much is waiting to be stored, releases `lock` and waits. Errors: those of
  /// DurableStore::status and DurableStore::wait_for_room.
  Status wait_for_room(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds most);
  /// Waits until everything is stored. The caller does not hold the lock. Errors: those of
  /// DurableStore::flush.
  Status flush(std::chrono::nanoseconds most);

 private:
  DurableStore* store_ = nullptr;
  StreamId stream_;
};

}  // namespace ddssec::rtps
