// Matches local with remote user endpoints and reports why they do not match (RTPS 8.5.4). Builtin
// endpoints have their own rules; see BuiltinMatcher.
#pragma once

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/reader_presence.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Keeps an index of the endpoints from `add` to `remove`. Two endpoints match if they have the
/// same topic, are compatible, neither is ignored, and security permits it.
class EndpointMatcher {
 public:
  EndpointMatcher(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes);

  // Local endpoints:
  void add(LocalWriter& writer);
  void add(LocalReader& reader);
  /// Call it before LocalEndpoints::remove.
  void remove(LocalWriter& writer);
  void remove(LocalReader& reader);
  /// Matches the endpoint again with all endpoints on its topic, after its policies changed or
  /// something was ignored.
  void match_all(LocalWriter& writer);
  void match_all(LocalReader& reader);
  /// As match_all, for all local writers and readers with each other.
  void match_own();

  // Remote endpoints:
  /// Stores what was announced, if there is room, and matches it.
  void add(RemoteParticipant& remote, EndpointData data);
  /// Removes the endpoint. With `may_return`, the keys that its participant has sent for it are
  /// kept.
  void remove(RemoteParticipant& remote, const EntityId& id, bool may_return = false);
  /// Called if something that proves nothing says that the endpoint has ended. Counts only for
  /// readers (ReaderPresence).
  void note_unproven_end(RemoteParticipant& remote, const EntityId& id);
  /// Matches all its endpoints again, after permissions changed. Returns true if any no longer
  /// match.
  bool match_all(RemoteParticipant& remote);
  /// Call it when the addresses that are used for the participant may have changed.
  void readdress(RemoteParticipant& remote);
  /// Removes all endpoints of the participant. If they may return, their keys are kept.
  void remove_all(RemoteParticipant& remote, bool may_return = false);
  /// Removes all endpoints on the topic, which is ignored from now on.
  void remove_topic(const std::string& name);
  /// Returns any remote endpoint on the topic.
  std::optional<EndpointData> endpoint_on(const std::string& topic_name) const;

  // Both:
  /// Called after the keys of the pair have arrived.
  void match(const EntityId& local, const Guid& remote);
  ReaderPresence& presence() { return presence_; }
  const ReaderPresence& presence() const { return presence_; }

 private:
  /// The endpoints on one topic: only these can match each other.
  struct TopicEndpoints {
    std::vector<LocalWriter*> writers;
    std::vector<LocalReader*> readers;
    std::set<Guid> remotes;
    bool empty() const { return writers.empty() && readers.empty() && remotes.empty(); }
  };
  /// Adds the endpoint to those that matched. If there is no room, another one gives way.
  template <class Local>
  void claim_place(Local& local, const EndpointData& endpoint);
  void match(LocalWriter& writer, RemoteParticipant& remote, const EndpointData& data);
  void match(LocalReader& reader, RemoteParticipant& remote, const EndpointData& data);
  void readdress(RemoteParticipant& remote, const RemoteEndpoint& endpoint);
  /// Matches two local endpoints.
  void match_own(LocalWriter& writer, LocalReader& reader);
  template <class Local>
  void match_remotes(Local& local);
  /// `stays` is true if the remote endpoint still exists, and may match again.
  void forget(LocalWriter& writer, const Guid& remote, bool stays = false);
  void forget(LocalReader& reader, const Guid& remote, bool stays = false);
  /// Called before a local endpoint is removed: `others` on its topic no longer match it.
  template <class Local>
  void part_from(const std::vector<Local*>& others, const Guid& endpoint);
  void forget_if_empty(const std::string& topic_name);

  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  std::map<std::string, TopicEndpoints> topics_;
  MatchPlaces places_;
  ReaderPresence presence_;
};

}  // namespace ddssec::rtps
