// Matches the builtin endpoints of remote participants with the local ones (RTPS 8.5.5,
// DDS-Security 1.2, clause 7.5.8).
#pragma once

#include "rtps/participant/builtin_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Matches and unmatches builtin endpoints as remote participants come, authenticate and leave.
class BuiltinMatcher {
 public:
  BuiltinMatcher(ParticipantCore& core, BuiltinEndpoints& builtin);

  /// Sets the function to call when messages of plain discovery in a participant's name contradict
  /// each other. It is for participants that match from now on.
  void on_contradiction(std::function<void(const Guid& writer)> contradicted) {
    contradicted_ = std::move(contradicted);
  }
  /// Matches all builtin endpoints of the participant. If it returns, announcements that anyone can
  /// send in its name are requested again; the others go on where they ended.
  void match(RemoteParticipant& remote, bool returns = false);
  /// Matches one local endpoint. Called when the keys for that participant and this endpoint have
  /// arrived.
  void match(const EntityId& local, RemoteParticipant& remote);
  /// If the participant may return with the same keys, it is remembered what has arrived of the
  /// announcements that only it can have sent.
  void unmatch(const RemoteParticipant& remote, bool may_return = false);
  /// Requests all plain announcements of the participant's endpoints again, or all secure ones.
  /// With `drops_recorded`, keys of the participant must protect them, and what it no longer keeps
  /// is not taken: anyone can repeat that.
  void refresh_announcements(RemoteParticipant& remote, bool secure = false,
                             bool drops_recorded = false);
  /// Requests again what the participant announces of itself by DCPSParticipantsSecure.
  void refresh_participant(RemoteParticipant& remote, bool drops_recorded = false);
  /// Tells the participant which announcements of ours there are: it requests those that it has not
  /// received, whatever was acknowledged in its name.
  void offer_again(const RemoteParticipant& remote);
  /// Returns true if all announcements of the participant of that kind have arrived, as far as is
  /// known.
  bool has_read(const RemoteParticipant& remote, bool secure = false) const;
  /// Call it when the addresses that are used for the participant may have changed.
  void readdress(const RemoteParticipant& remote, MonotonicTime now);
  /// Call it when a message from the participant's endpoints of DCPSParticipantsSecure has
  /// arrived.
  void note_participants_secure(RemoteParticipant& remote);

 private:
  void match(const BuiltinTopicInfo& info, RemoteParticipant& remote, bool with_writer,
             bool again = false, const std::optional<Sha256Digest>& keys = {});
  void read_again(const BuiltinTopicInfo& info, RemoteParticipant& remote, bool drops_recorded);
  std::optional<Sha256Digest> proven_keys(const EntityId& reader, const Guid& writer) const;

  ParticipantCore& core_;
  BuiltinEndpoints& builtin_;
  std::function<void(const Guid&)> contradicted_;
};

}  // namespace ddssec::rtps
