// What the receiver of messages asks of a participant: which endpoints there are. And what it tells
// it beside.
#pragma once

#include <span>

#include "rtps/reliability/stateful_reader.hpp"

namespace ddssec::rtps {

/// Finds our endpoints by what a submessage says.
class EndpointLookup {
 public:
  virtual ~EndpointLookup() = default;
  /// The readers that this remote writer may have matched. Valid until endpoints change.
  virtual std::span<StatefulReader* const> readers_of(const Guid& writer) = 0;
  /// Our writer of that id, as it speaks to readers of that participant; nullptr: there is none.
  virtual StatefulWriter* writer_for(const EntityId& writer, const GuidPrefix& reader) = 0;
};

/// Learns what messages say beside what they carry to readers and writers.
class MessageListener {
 public:
  virtual ~MessageListener() = default;
  /// A DATA of the SPDP writer (RTPS 8.5.3). Errors: those of reading it.
  virtual Status on_announcement(const GuidPrefix& source, const Data& data) = 0;
  /// Sent to the endpoint for authentication, which anybody can do (DDS-Security 7.4.3).
  virtual void on_stateless(const GuidPrefix& source, BytesView payload) = 0;
  virtual void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) = 0;
  /// A heartbeat of a builtin writer, whether it matched one of our readers or not.
  virtual void on_builtin_heartbeat(const Guid& writer) = 0;
  /// The writer, which matched a reader of ours, asserted its liveliness: by a sample, or by a
  /// heartbeat that says so.
  virtual void on_alive(const Guid& writer) = 0;
  /// The reader acknowledged something to the writer, which it matched.
  virtual void on_acknack(const EntityId& writer, const Guid& reader) = 0;
  /// Something that only the peer can have protected came by the volatile secure channel.
  virtual void on_key_exchange(const GuidPrefix& source) = 0;
  /// After all of a message. `is_protected`: by the participant's own key.
  virtual void on_message(const GuidPrefix& source, bool is_protected) = 0;
};

}  // namespace ddssec::rtps
