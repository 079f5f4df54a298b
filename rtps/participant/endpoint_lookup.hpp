// The two interfaces through which MessageReceiver uses its participant. One finds endpoints, and
// the other receives what is not for an endpoint.
#pragma once

#include <span>

#include "rtps/reliability/stateful_reader.hpp"

namespace ddssec::rtps {

/// Finds the local endpoints that a submessage is addressed to.
class EndpointLookup {
 public:
  virtual ~EndpointLookup() = default;
  /// Returns the local readers that this remote writer may have matched. Valid until endpoints
  /// change.
  virtual std::span<StatefulReader* const> readers_of(const Guid& writer) = 0;
  /// Returns the local writer with this id, for a reader of that participant, or nullptr if there
  /// is none.
  virtual StatefulWriter* writer_for(const EntityId& writer, const GuidPrefix& reader) = 0;
  /// True if the participant's writers, like those of ddssec, send the key of an instance that they
  /// dispose or unregister. If INFO_TS is not protected, such writers also send the source time
  /// next to the sample. Other vendors may do neither.
  virtual bool sends_keys(const GuidPrefix& participant) = 0;
  /// True if the participant's writers mark protected payloads that end an instance (end_mark).
  virtual bool marks_ends(const GuidPrefix& participant) = 0;
};

/// The facts that a message shows about its sender, whatever its contents.
struct SignsOfLife {
  bool is_news = false;      ///< a local endpoint received something new
  bool is_directed = false;  ///< the message named the local participant as its receiver
  bool is_proof = false;     ///< the new part was protected by a key of the sender
  /// It is also new by a count that is kept as long as the sender's keys are (DormantPeers).
  bool is_lasting_proof = false;
};

/// Receives the parts of messages that are not for a matched reader or writer.
class MessageListener {
 public:
  virtual ~MessageListener() = default;
  /// Receives a DATA of the SPDP writer (RTPS 8.5.3). Errors: those of reading it.
  virtual Status on_announcement(const GuidPrefix& source, const Data& data) = 0;
  /// Receives a message to the stateless endpoint, before authentication (DDS-Security 1.2,
  /// clause 7.5.3). It is not proven.
  virtual void on_stateless(const GuidPrefix& source, BytesView payload) = 0;
  virtual void on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) = 0;
  /// Receives a HEARTBEAT of a builtin writer, whether it matched a local reader or not.
  virtual void on_builtin_heartbeat(const Guid& writer) = 0;
  /// Called when a writer that matched a local reader asserted its liveliness, by a sample or by a
  /// HEARTBEAT with the liveliness flag.
  virtual void on_alive(const Guid& writer) = 0;
  /// Receives an ACKNACK of a reader of `source`, for a local writer that it matched.
  /// `is_protected` means that keys of `source` protect it.
  virtual void on_acknack(const GuidPrefix& source, const AckNack& acknack, bool is_protected) = 0;
  /// Called when a submessage that only the peer can have protected arrived on the volatile secure
  /// channel.
  virtual void on_key_exchange(const GuidPrefix& source) = 0;
  /// Called after the last submessage of each source.
  virtual void on_message(const GuidPrefix& source, const SignsOfLife& signs) = 0;
};

}  // namespace ddssec::rtps
