// What limits the harm of endpoint announcements that anyone can have sent.
#pragma once

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

class ClearAnnouncements final : private Timed {
 public:
  ClearAnnouncements(ParticipantCore& core, RemoteParticipants& remotes, EndpointMatcher& matcher,
                     BuiltinMatcher& builtin)
      : Timed(core.timers), core_(core), remotes_(remotes), matcher_(matcher), builtin_(builtin) {}

  /// Makes room for a securely announced endpoint: removes the unprotected announcement of the same
  /// endpoint and, if there is still no room, all unprotected ones. Any host may have sent those.
  void give_way(RemoteParticipant& remote, const EndpointData& secure);
  /// The participant's endpoint is announced, or has ended. If anyone can have said so and it
  /// changes what is known, the participant's announcements are read again later (SecondReading).
  /// Returns false if it changes nothing.
  bool note_announced(RemoteParticipant& remote, const EndpointData& endpoint);
  void note_ended(RemoteParticipant& remote, const EntityId& endpoint, bool secure);

 private:
  void on_time(MonotonicTime now) override;
  bool is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint, bool secure) const;
  void read_again_later(RemoteParticipant& remote);

  ParticipantCore& core_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
};

}  // namespace ddssec::rtps
