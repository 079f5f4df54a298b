// Tracks whether the remote readers that match are present: they may not be ready yet, or be said
// to have ended.
#pragma once

#include <algorithm>
#include <functional>

#include "rtps/participant/match_places.hpp"
#include "rtps/participant/reader_end_checks.hpp"
#include "rtps/participant/readiness_queue.hpp"

namespace ddssec::rtps {

/// EndpointMatcher reports each match of a writer and its end to this class, and Discovery reports
/// the messages that it hears.
class ReaderPresence final : private ReaderEndChecks::Host {
 public:
  /// `match_again` is called when a reader that counted as ended is heard.
  ReaderPresence(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes,
                 MatchPlaces& places,
                 std::function<void(const EntityId& writer, const Guid& reader)> match_again)
      : core_(core),
        local_(local),
        remotes_(remotes),
        places_(places),
        match_again_(std::move(match_again)) {}

  /// Notes that the reader matches from now on. Returns true if that is not yet to be reported to
  /// the writer's owner (ReadinessQueue).
  bool awaits(LocalWriter& writer, const EndpointData& reader);
  /// Notes that the reader does not match any more.
  void forget(LocalWriter& writer, const Guid& reader);
  /// Called if something that proves nothing says that the reader has ended (ReaderEndChecks).
  void note_unproven_end(LocalWriter& writer, const Guid& reader);
  /// Notes that a reader of `source` sent an ACKNACK to the local writer. `is_protected` means that
  /// keys of `source` protect it.
  void note_heard(LocalWriter& writer, const GuidPrefix& source, const AckNack& acknack,
                  bool is_protected);

  void tick();
  MonotonicTime next_tick() const { return std::min(readiness_.next(), end_checks_.next()); }

 private:
  bool shows_readiness(const LocalWriter& writer, const EndpointData& reader) const;
  void note_ready(LocalWriter& writer, const Guid& reader);
  std::optional<std::uint64_t> answers(const ReaderEndChecks::ReaderPair& pair) override;
  void request_sign_of_life(const ReaderEndChecks::ReaderPair& pair) override;
  void on_no_answer(const ReaderEndChecks::ReaderPair& pair) override;

  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  MatchPlaces& places_;
  const std::function<void(const EntityId&, const Guid&)> match_again_;
  ReadinessQueue readiness_;
  ReaderEndChecks end_checks_{*this};
};

}  // namespace ddssec::rtps
