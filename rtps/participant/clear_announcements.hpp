// Limits the harm of endpoint announcements that anyone can have sent.
#pragma once

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

/// Doubts each change by an unprotected announcement, and asks the participant again what it
/// announces.
class ClearAnnouncements final : private TimedObject {
 public:
  /// How often a participant is told which announcements of ours there are.
  static constexpr MonotonicTime kOfferPeriod = std::chrono::seconds(32);

  ClearAnnouncements(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes,
                     EndpointMatcher& matcher, BuiltinMatcher& builtin);
  ClearAnnouncements(const ClearAnnouncements&) = delete;
  ClearAnnouncements& operator=(const ClearAnnouncements&) = delete;

  /// Begins with a participant that was accepted. If anyone can send announcements in its name,
  /// both sides compare from time to time what is announced. If anyone can redirect to us what it
  /// acknowledged to others, it is told from time to time what we announced.
  void begin(RemoteParticipant& remote);

  /// Removes the unprotected announcement of an endpoint that is announced securely. Any host may
  /// have sent it. While the governance changes, the endpoint keeps its matches if the secure
  /// announcement only confirms the other one.
  void give_way_to(RemoteParticipant& remote, const EndpointData& secure);
  /// Notes that the participant's endpoint is announced. If anyone can have announced it and it
  /// changes what is known, the participant's announcements are read again later
  /// (AnnouncementRefresh). Returns false if it changes nothing, or not before that.
  bool note_announced(RemoteParticipant& remote, const EndpointData& endpoint);
  /// Removes an endpoint that is said to have ended. If anyone can have said so, its keys are kept,
  /// and the participant's announcements are read again later. Returns false if the endpoint is not
  /// removed, or not before that.
  bool remove(RemoteParticipant& remote, const EntityId& endpoint, bool secure);

 private:
  void on_time(MonotonicTime now) override;
  bool is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint, bool secure) const;
  /// True if the endpoint is known, and only its participant can have announced it.
  bool is_proven(const RemoteParticipant& remote, const EntityId& endpoint) const;
  void note_change(AnnouncementRefresh& refresh);
  void note_contradiction(const GuidPrefix& participant);
  /// Returns the local endpoints of the other kind.
  std::vector<EntityId> counterparts(const EntityId& endpoint) const;
  /// True if there are keys that the endpoint sent for a local one.
  bool has_keys(const Guid& endpoint) const;
  /// Ends a refresh whose answer must have arrived by now.
  void on_refreshed(RemoteParticipant& remote);
  /// Requests the keys of endpoints that came back after their keys were given up. Raises an event
  /// if they do not arrive.
  void request_missing_keys(RemoteParticipant& remote);
  /// Returns true if they were missing. `again` is true if they were requested before.
  bool request_keys(const Guid& endpoint, bool again);

  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
};

}  // namespace ddssec::rtps
