// What DURABILITY TRANSIENT and PERSISTENT ask of a DataWriter (DDS 1.4, 2.2.3.4): its samples in a
// store that outlives it.
#pragma once

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

/// The stream of one writer in a DurableStore; nothing happens before it is opened. The caller
/// serializes calls.
class WriterDurability {
 public:
  WriterDurability() = default;
  /// Another writer may continue the stream from here on.
  ~WriterDurability();
  WriterDurability(const WriterDurability&) = delete;
  WriterDurability& operator=(const WriterDurability&) = delete;

  /// Returns what an earlier writer left in the stream. `store` outlives this. Errors: those of
  /// DurableStore::open_stream.
  Result<std::vector<Change>> open(DurableStore& store, StreamKey key,
                                   const DurabilityService& service);
  bool is_open() const { return store_ != nullptr; }

  /// Stores the change as number `number` of `writer`; never waits.
  void append(Change& change, const Guid& writer, SequenceNumber number, Time now);
  /// Releases `lock` and waits if more is on its way to the store than should be. Errors: those of
  /// DurableStore::status and DurableStore::wait_for_room.
  Status wait_for_room(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds most);
  /// Without a lock: waits until all is stored. Errors: those of DurableStore::flush.
  Status flush(std::chrono::nanoseconds most);

 private:
  DurableStore* store_ = nullptr;
  StreamId stream_;
};

}  // namespace ddssec::rtps
