// The writers and readers of the local participant, including its builtin ones, and their
// announcement by SEDP (RTPS 8.5.4).
#pragma once

#include <map>
#include <set>

#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/participant/match_table.hpp"
#include "rtps/participant/participant_core.hpp"
#include "rtps/participant/waiting_matches.hpp"

namespace ddssec::rtps {

/// A writer of this participant, with its matches.
struct LocalWriter {
  EndpointData data;
  EndpointListener* listener = nullptr;
  std::unique_ptr<StatefulWriter> protocol;
  MatchTable matched = {};
  std::set<Guid> unready = {};  ///< matched, but not yet reported to the owner (ReadinessQueue)
  /// Readers that are not matched any more because they stayed silent (ReaderEndChecks), with their
  /// answers until then. They match again when they are heard.
  std::map<Guid, RecentMessages<AckNack>> silent = {};
  WaitingMatches waiting = {};
};

/// A reader of this participant, with its matches.
struct LocalReader {
  EndpointData data;
  EndpointListener* listener = nullptr;
  std::unique_ptr<StatefulReader> protocol;
  MatchTable matched = {};
  WaitingMatches waiting = {};
};

/// The local endpoints of one participant. It knows remote endpoints only by their GUIDs, as
/// EndpointMatcher matched them.
class LocalEndpoints final : public ProcessPeer {
 public:
  /// `deliver` is called with the changes that arrive for the builtin readers.
  LocalEndpoints(ParticipantCore& core, BuiltinEndpoints::Deliver deliver);

  /// Creates an endpoint, which is not announced yet. It exists until it is removed; the listener
  /// must live as long. Errors: rtps_qos_inconsistent, and for a secured participant those of
  /// access control.
  Result<LocalWriter*> create_writer(EndpointDescription request, EndpointListener& listener);
  Result<LocalReader*> create_reader(EndpointDescription request, EndpointListener& listener);
  /// Announces a local endpoint, or its changes.
  void publish(const EndpointData& data);
  /// Announces a local endpoint by secure discovery, since the governance protects the discovery of
  /// its topic from now on. The unprotected announcement stays until end_moves.
  void publish_moved(const EndpointData& data);
  /// True if an unprotected announcement stands beside a secure one.
  bool any_moves() const { return !moved_.empty(); }
  /// Peers know the secure announcements: the unprotected ones end.
  void end_moves();
  /// Removes the endpoint and its announcement. It must not be matched any more.
  void remove(const Guid& endpoint);
  /// Creates a GUID for a publisher.
  Guid create_group();

  /// All of these return nullptr if it is not a local endpoint.
  LocalWriter* find_writer(const EntityId& id);
  const LocalWriter* find_writer(const EntityId& id) const;
  LocalReader* find_reader(const EntityId& id);
  const EndpointData* find(const EntityId& id) const;
  std::map<EntityId, LocalWriter>& writers() { return writers_; }
  std::map<EntityId, LocalReader>& readers() { return readers_; }
  BuiltinEndpoints& builtin() { return builtin_; }
  /// See StatefulReader and StatefulWriter, for one local endpoint; without an entity, for all.
  void note_key_change(const EntityId& local, const Guid& remote, KeyChange change);
  /// Returns the remote endpoints that match a local one.
  std::vector<Guid> matched(const Guid& endpoint) const;

  // ProcessPeer:
  const GuidPrefix& prefix() const override { return core_.config.prefix; }
  bool is_secured() const override { return core_.security != nullptr; }
  bool is_unprotected(const EntityId& endpoint) const override;
  StatefulWriter* writer(const Guid& guid) const override;
  StatefulReader* reader(const Guid& guid) const override;

 private:
  EntityId next_id(std::uint8_t kind);
  EndpointData data_of(EndpointDescription request, EndpointKind kind);
  /// Asks access control for permission, and announces the resulting attributes.
  Status ask_access_control(EndpointData& data, EndpointListener& listener);
  void unpublish(const Guid& endpoint, bool securely);
  bool is_announced_securely(const EntityId& endpoint) const;
  StatefulWriter& sedp_writer(const EntityId& endpoint, bool securely);

  ParticipantCore& core_;
  BuiltinEndpoints builtin_;
  std::map<EntityId, LocalWriter> writers_;
  std::map<EntityId, LocalReader> readers_;
  std::uint32_t next_entity_;
  std::set<EntityId> moved_;  ///< announced by both discoveries for a while
};

}  // namespace ddssec::rtps
