// What happens to announcements that anyone can have sent, when the governance protects discovery
// from then on.
#pragma once

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"

namespace ddssec::rtps {

/// Reads again what authenticated participants announce of their endpoints and of themselves, and
/// forgets endpoints that they do not confirm. A forged announcement from before must not count as
/// one under their keys.
class ProvenRefreshes {
 public:
  ProvenRefreshes(ParticipantCore& core, RemoteParticipants& remotes, EndpointMatcher& matcher,
                  BuiltinMatcher& builtin)
      : core_(core), remotes_(remotes), matcher_(matcher), builtin_(builtin) {}

  /// Call it once a second: begins when a change of the domain has ended.
  void tick();
  /// Reads again what the participant announces under its keys: former ones have ended, with which
  /// others may have announced in its name, or said that an endpoint has ended.
  void read_again(const GuidPrefix& participant);
  /// The endpoint is announced. If it was known with other policies that a match keeps, its matches
  /// end first: those policies were forged.
  void note_announced(RemoteParticipant& remote, const EndpointData& endpoint);

 private:
  void begin(const spi::ParticipantSecurityAttributes& former);
  void begin(RemoteParticipant& remote, bool secure, bool drops_recorded = false);
  bool has_read(const RemoteParticipant& remote) const;

  ParticipantCore& core_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
  MonotonicTime next_ = kNever;  ///< when to check whether they have confirmed everything
};

}  // namespace ddssec::rtps
