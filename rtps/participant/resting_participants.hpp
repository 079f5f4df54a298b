// Participants whose lease ended and whose keys are kept (DormantPeers).
#pragma once

#include <vector>

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

/// Remembers what is known of them, and brings them back when they have shown that they are there.
class RestingParticipants {
 public:
  /// The limit for the announcements of one participant, with a price for each endpoint
  /// (RemoteParticipants). One that announces more is removed, with its keys.
  static constexpr std::size_t kMaxEndpointOctets = std::size_t{1} << 20;

  RestingParticipants(ParticipantCore& core, RemoteParticipants& remotes, EndpointMatcher& matcher,
                      BuiltinMatcher& builtin)
      : core_(core), remotes_(remotes), matcher_(matcher), builtin_(builtin) {}

  /// True if the participant can come back when its lease ends now.
  bool can_keep(const RemoteParticipant& remote) const;
  /// Removes such a participant for now: its endpoints are unmatched, and it is reported as gone.
  void rest(RemoteParticipant& remote);
  /// Adds a participant that has answered; anything else in its name must have been removed.
  /// Returns nullptr if it cannot come back any more. It is to be accepted if it is authenticated.
  RemoteParticipant* wake(const GuidPrefix& prefix);
  /// Matches the endpoints of a participant that came back and was accepted.
  void match_again(RemoteParticipant& remote);

 private:
  struct RestingRemote {
    RemoteParticipant remote;
    std::vector<EndpointData> endpoints;  ///< those that only the participant can have announced
  };

  ParticipantCore& core_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
  std::map<GuidPrefix, RestingRemote> resting_;
};

}  // namespace ddssec::rtps
