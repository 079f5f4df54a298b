// Which of our endpoints matches which remote one, and why not (RTPS 8.5.4). User endpoints only:
// builtin ones have rules of their own, see BuiltinMatcher.
#pragma once

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/readiness_queue.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Endpoints are in its index from `add` to `remove`. Two of them match if their topics are the
/// same, they are compatible, neither is ignored, and security permits it.
class EndpointMatcher {
 public:
  EndpointMatcher(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes);

  // Ours.
  void add(LocalWriter& writer);
  void add(LocalReader& reader);
  /// Before LocalEndpoints::remove.
  void remove(LocalWriter& writer);
  void remove(LocalReader& reader);
  /// Once more with all of its topic, after its policies changed or something is ignored.
  void match_all(LocalWriter& writer);
  void match_all(LocalReader& reader);
  /// The same for all our writers and readers with each other.
  void match_own();

  // Theirs.
  /// Keeps what was announced, if there is room, and matches it.
  void add(RemoteParticipant& remote, EndpointData data);
  void remove(RemoteParticipant& remote, const EntityId& id);
  /// All of the participant's endpoints.
  void remove_all(RemoteParticipant& remote);
  /// All endpoints on the topic, which is ignored from now on.
  void remove_topic(const std::string& name);
  /// Any remote endpoint on the topic.
  std::optional<EndpointData> endpoint_on(const std::string& topic_name) const;

  // Both.
  /// After the keys of the pair have arrived.
  void match(const EntityId& local, const Guid& remote);
  /// The reader sent something to our writer.
  void note_ready(LocalWriter& writer, const Guid& reader);
  void tick();
  MonotonicTime next_tick() const { return readiness_.next(); }

 private:
  /// The endpoints on one topic: only these can match.
  struct TopicEnds {
    std::vector<LocalWriter*> writers;
    std::vector<LocalReader*> readers;
    std::set<Guid> remotes;
    bool empty() const { return writers.empty() && readers.empty() && remotes.empty(); }
  };
  enum class Verdict { refused, awaits_keys, ready };

  /// False: the identity of `remote` has all the matches that it may have with this endpoint, which
  /// is counted and once raises an event.
  bool has_place(const MatchTable& matched, RemoteParticipant& remote,
                 const EndpointData& endpoint);
  /// Access control comes first: a participant that may not use the topic changes no status of
  /// ours.
  Verdict judge(const EndpointData& local, EndpointListener& listener, const EndpointData& remote);
  void match(LocalWriter& writer, RemoteParticipant& remote, const EndpointData& data);
  void match(LocalReader& reader, RemoteParticipant& remote, const EndpointData& data);
  /// Two of our own.
  void match_own(LocalWriter& writer, LocalReader& reader);
  template <class Local>
  void match_remotes(Local& local);
  void forget(LocalWriter& writer, const Guid& remote);
  void forget(LocalReader& reader, const Guid& remote);
  /// Before an endpoint of ours is removed: `others` on its topic no longer match it.
  template <class Local>
  void part_from(const std::vector<Local*>& others, const Guid& endpoint);
  /// The participant of this process that may be called directly for this pair, or nullptr.
  const Neighbour* neighbour(const EntityId& local, const Guid& remote) const;
  bool shows_readiness(const LocalWriter& writer, const EndpointData& reader) const;
  void forget_if_empty(const std::string& topic_name);

  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  std::map<std::string, TopicEnds> topics_;
  ReadinessQueue readiness_;
};

}  // namespace ddssec::rtps
