// Which builtin endpoints of a remote participant match ours (RTPS 8.5.5, DDS-Security 7.4.5).
#pragma once

#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

class BuiltinMatcher {
 public:
  BuiltinMatcher(ParticipantCore& core, BuiltinEndpoints& builtin);

  /// All that the participant has.
  void match(RemoteParticipant& remote);
  /// The keys of one of ours for that participant are here.
  void match(const EntityId& local, RemoteParticipant& remote);
  void unmatch(const RemoteParticipant& remote);
  /// Something came from its endpoints of DCPSParticipantsSecure.
  void note_participants_secure(RemoteParticipant& remote);

 private:
  void match(const BuiltinTopicInfo& info, RemoteParticipant& remote, bool with_writer);

  ParticipantCore& core_;
  BuiltinEndpoints& builtin_;
};

}  // namespace ddssec::rtps
