// Sends changes to readers of other processes on this machine that find payloads in memory.
#pragma once

#include "rtps/reliability/matched_readers.hpp"
#include "rtps/reliability/sample_memory.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// Only a change that was just written goes through memory. A change that is sent again goes in
/// messages to these readers too. The constructor's arguments must outlive this object.
class MemoryWriting {
 public:
  MemoryWriting(MatchedReaders& readers, WriterMessages& messages, const WriterHistory& history)
      : readers_(readers), messages_(messages), history_(history) {}

  /// Sets the memory, which must outlive its use. nullptr means that all payloads are sent in
  /// messages.
  void use(SampleMemory* memory) { memory_ = memory; }
  /// Sets whether readers of that participant find payloads in memory. The sender must be flushed
  /// before.
  void set_reading(const GuidPrefix& participant, bool in_memory);

  /// Puts a change that was just written into memory. Returns an empty value if it must be sent in
  /// messages.
  std::optional<MemoryReference> store(const Change& change, MonotonicTime now);
  /// Sends the change to all readers. `memory` is the place of its payload.
  void send(const Change& change, const std::optional<MemoryReference>& memory);

 private:
  MatchedReaders& readers_;
  WriterMessages& messages_;
  const WriterHistory& history_;
  SampleMemory* memory_ = nullptr;
};

}  // namespace ddssec::rtps
