// Decides which endpoints of an identity have a place among the matches of a local endpoint, and
// which wait for one.
#pragma once

#include <functional>

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// EndpointMatcher asks it before each match, and reports the end of each.
class MatchPlaces final : private TimedObject {
 public:
  /// The number of waiting endpoints that are tried at a time for one local endpoint, and the pause
  /// after that.
  static constexpr int kMaxTries = 32;
  static constexpr MonotonicTime kPause = std::chrono::milliseconds(1);

  /// `match_again` is called for an endpoint that need not wait any more.
  MatchPlaces(ParticipantCore& core, LocalEndpoints& local,
              std::function<void(const EntityId& local, const Guid& remote)> match_again)
      : TimedObject(core.timers),
        core_(core),
        local_(local),
        match_again_(std::move(match_again)) {}

  /// The matches of a local endpoint, which may be a writer or a reader.
  struct Local {
    template <class T>
    explicit Local(T& endpoint)
        : id(endpoint.data.guid.entity), matched(endpoint.matched), waiting(endpoint.waiting) {}
    const EntityId& id;
    MatchTable& matched;
    WaitingMatches& waiting;
  };
  /// Returns false if the identity of `remote` has reached its limit of matches with this endpoint,
  /// and no match can be replaced (replaceable_match). Then the remote endpoint waits. This is
  /// counted, and an event is raised once.
  bool has_place(const Local& local, RemoteParticipant& remote, const EndpointData& endpoint);
  /// Returns the endpoint whose match must end before this one can match. There is one if there is
  /// no room, and if anyone can have announced the former endpoint, but not this one.
  std::optional<Guid> replaceable_match(const Local& local, const EndpointData& endpoint) const;
  /// Notes that the match of that endpoint was ended for another one.
  void note_displaced(const Local& local, const Guid& remote);
  /// Notes that the endpoint matches.
  void claim(const Local& local, const EndpointData& endpoint);
  /// Notes that a match has ended.
  void note_room(const Local& local);

 private:
  void on_time(MonotonicTime now) override;
  /// Matches some of the waiting endpoints.
  void fill(const Local& local);
  bool has_macs(const EntityId& local) const;

  ParticipantCore& core_;
  LocalEndpoints& local_;
  const std::function<void(const EntityId&, const Guid&)> match_again_;
  std::set<EntityId> with_room_;  ///< the local endpoints that may have room for waiting endpoints
};

}  // namespace ddssec::rtps
