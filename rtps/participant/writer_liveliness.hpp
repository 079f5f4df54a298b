// The writer liveliness protocol (RTPS 8.4.13): says that our writers live, and hears whether
// remote ones do.
#pragma once

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

class WriterLiveliness {
 public:
  WriterLiveliness(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes);

  /// A writer of ours with that policy exists from now on.
  void expect(const Liveliness& liveliness);
  /// Tells all that our writers of this kind live.
  void assert_liveliness(LivelinessKind kind);
  /// Asserts those of kind AUTOMATIC, if it is time.
  void tick();
  MonotonicTime next_tick() const { return next_assertion_; }

  /// A sample of DCPSParticipantMessage, or of its secure double.
  void on_participant_message(const Change& change, bool secure);
  /// `remote` asserted the liveliness of all its writers of this kind: AUTOMATIC ones by any
  /// message, MANUAL_BY_PARTICIPANT ones by a sample of any of them or a ParticipantMessage.
  void note_alive(RemoteParticipant& remote, LivelinessKind kind);
  /// This writer asserted itself, by a sample or a heartbeat that says so.
  void note_alive(const Guid& writer);

 private:
  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  MonotonicTime next_assertion_ = kNever;
};

}  // namespace ddssec::rtps
