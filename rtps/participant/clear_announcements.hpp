// What limits the harm of endpoint announcements that anyone can have sent.
#pragma once

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

class ClearAnnouncements final : private Timed {
 public:
  ClearAnnouncements(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes,
                     EndpointMatcher& matcher, BuiltinMatcher& builtin)
      : Timed(core.timers),
        core_(core),
        local_(local),
        remotes_(remotes),
        matcher_(matcher),
        builtin_(builtin) {}

  /// Makes room for a securely announced endpoint: removes the unprotected announcement of the same
  /// endpoint and, if there is still no room, all unprotected ones. Any host may have sent those.
  void give_way(RemoteParticipant& remote, const EndpointData& secure);
  /// The participant's endpoint is announced. If anyone can have said so and it changes what is
  /// known, the participant's announcements are read again later (SecondReading). Returns false if
  /// it changes nothing.
  bool note_announced(RemoteParticipant& remote, const EndpointData& endpoint);
  /// The endpoint has ended, and is removed. The same; its keys are kept meanwhile.
  void remove(RemoteParticipant& remote, const EntityId& endpoint, bool secure);

 private:
  void on_time(MonotonicTime now) override;
  bool is_doubtful(const RemoteParticipant& remote, const EntityId& endpoint, bool secure) const;
  /// They have not come back.
  void give_up(const RemoteParticipant& remote, std::span<const EntityId> ended);

  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
};

}  // namespace ddssec::rtps
