// The writer liveliness protocol (RTPS 8.4.13): asserts the liveliness of local writers, and tracks
// that of remote ones.
#pragma once

#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// Sends and receives the participant messages of one participant.
class WriterLiveliness {
 public:
  WriterLiveliness(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes);

  /// Notes that a local writer with this policy exists.
  void expect(const Liveliness& liveliness);
  /// Asserts the liveliness of the local writers of this kind to all participants.
  void assert_liveliness(LivelinessKind kind);
  /// Asserts the writers of kind AUTOMATIC, if that is due.
  void tick();
  MonotonicTime next_tick() const { return next_assertion_; }

  /// Processes a sample of DCPSParticipantMessage, or of its secure counterpart.
  void on_participant_message(const Change& change, bool secure);
  /// Notes that `remote` asserted the liveliness of all its writers of this kind: AUTOMATIC writers
  /// by any message, MANUAL_BY_PARTICIPANT writers by a sample of any of them or by a
  /// ParticipantMessage.
  void note_alive(RemoteParticipant& remote, LivelinessKind kind);
  /// Notes that this writer asserted its liveliness, by a sample or by a HEARTBEAT with the
  /// liveliness flag.
  void note_alive(const Guid& writer);

 private:
  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  MonotonicTime next_assertion_ = kNever;
};

}  // namespace ddssec::rtps
