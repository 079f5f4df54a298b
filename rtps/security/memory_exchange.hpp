// Shared memory between this participant and authenticated peers on the same machine: the memory of
// local writers (WrittenMemory), that of remote writers (MappedMemory), and the messages of both
// sides over the protected channel.
//
// The writer's participant offers memory to one peer that has a matched reader. The offer has a
// token with which the peer fetches the descriptor over a local socket. If any step fails, or the
// peer does not answer, payloads go to it in messages as before.
#pragma once

#include "rtps/security/mapped_memory.hpp"
#include "rtps/security/written_memory.hpp"

namespace ddssec::rtps {

/// The shared memory of one local participant. Never blocks. No clock or lock.
class MemoryExchange {
 public:
  /// Both arguments must outlive it. Errors: those of the local socket.
  static memory::MemoryResult<std::unique_ptr<MemoryExchange>> make(
      SecurityCore& core, CryptoTokenExchange& exchange, const spi::SharedMemory& settings);

  /// Starts a thread for work that other processes could delay. Call it before the
  /// participant is served, except in tests. If no thread can be started, an event reports that.
  void start();
  /// Returns a descriptor that is readable when `serve` must be called.
  int descriptor() const { return core_.passing->descriptor(); }
  void serve(MonotonicTime now);
  /// Returns when `serve` must be called even if the descriptor is not readable.
  MonotonicTime next_tick() const;

  // Local writers:
  /// Note that a reader of a peer on this machine has matched the writer, or no longer does.
  void add_reader(StatefulWriter& writer, const Guid& reader);
  void remove_reader(const EntityId& writer, const Guid& reader);
  /// Call it before the writer is destroyed.
  void remove_writer(const EntityId& writer);
  /// Returns how many peers may still fetch a descriptor.
  std::size_t offers() const { return core_.passing->offers().size(); }

  const KeptMemory& kept() const { return core_.kept; }

  /// Returns the memory of remote writers.
  MappedMemory& mapped() { return mapped_; }

 private:
  MemoryExchange(SecurityCore& core, CryptoTokenExchange& exchange,
                 const spi::SharedMemory& settings,
                 std::unique_ptr<memory::DescriptorPassing> passing);
  void adopt_prepared(MonotonicTime now);
  void poll_kept_memory(MonotonicTime now);
  void on_message(Peer& peer, const spi::Token& token);
  /// True if participants of the peer's identity passed a descriptor that was not one of memory.
  bool is_barred(const Peer& peer) const;
  void answer(const GuidPrefix& to, const MemoryAnswer& answer);

  /// A writer, which is told when its memory ends.
  struct WriterEntry {
    StatefulWriter& writer;
    std::unique_ptr<WrittenMemory> memory;
  };

  static constexpr std::size_t kMaxBarred = 256;

  MemoryCore core_;
  std::set<std::string> barred_;
  MonotonicTime next_look_ = kNever;  ///< when to check whether kept memory was returned
  std::map<EntityId, WriterEntry> writers_;
  MappedMemory mapped_;
};

/// Answers an offer where shared memory is off, so that the peer can report it.
void decline_memory(CryptoTokenExchange& exchange, Peer& peer, const GenericMessage& message);

}  // namespace ddssec::rtps
