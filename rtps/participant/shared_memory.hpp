// Tells shared memory which endpoints match (MemoryExchange).
#pragma once

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Returns nullptr if the participant is not secured, or if shared memory is off.
MemoryExchange* memory_of(const ParticipantCore& core);
/// Starts the thread of shared memory, if the participant has any (MemoryExchange::start).
void start_memory(const ParticipantCore& core);
/// Returns a descriptor that is readable when `serve_memory` must be called. Empty if there is no
/// shared memory.
std::optional<int> memory_descriptor(const ParticipantCore& core);
void serve_memory(const ParticipantCore& core, MonotonicTime now);

/// Notes that a reader has matched a local writer. `locators` are those to which its messages are
/// sent. Only readers of authenticated ddssec participants on this machine that get keys to read
/// with are offered memory.
void note_reader(ParticipantCore& core, LocalWriter& writer, const RemoteParticipant& remote,
                 const Guid& reader, const LocatorList& locators);
void note_reader_gone(ParticipantCore& core, const EntityId& writer, const Guid& reader);
void note_own_writer_gone(ParticipantCore& core, const EntityId& writer);

/// Notes that a writer has matched a local reader. `locators` are those to which the reader sends
/// its answers.
void note_writer(ParticipantCore& core, const EntityId& reader, const RemoteParticipant& remote,
                 const Guid& writer, const LocatorList& locators);
void note_writer_gone(ParticipantCore& core, const EntityId& reader, const Guid& writer);

}  // namespace ddssec::rtps
