// Events: the messages for the operator of a system, one for each refusal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "base/result.hpp"

namespace ddssec {

/// The proof that a peer has given for the subject name that an event gives it.
enum class PeerProof : std::uint8_t {
  claimed,        ///< the name comes from an announcement, which anyone can send
  authenticated,  ///< the name is in the certificate with which the peer authenticated
  not_a_peer      ///< the event is about the local participant or about no participant
};

/// One refusal or notice.
struct Event {
  Error error;
  Severity severity;
  std::string peer_subject;  ///< subject name of the peer; empty if local or unknown
  std::string guid;          ///< GUID of the participant concerned; empty if unknown
  PeerProof proof;
  bool is_returned = false;  ///< the application also receives the error as the result of its call

  Event(Error reason, std::string subject = {}, std::string whose_guid = {},
        PeerProof subject_proof = PeerProof::claimed)
      : error(std::move(reason)),
        severity(info(error.code()).severity),
        peer_subject(std::move(subject)),
        guid(std::move(whose_guid)),
        proof(subject_proof) {}

  /// Makes the event for an error that the application also receives as the result of its call. A
  /// log of events includes it. A program that prints both its events and its errors leaves it out.
  static Event of_returned(Error reason) {
    Event out(std::move(reason), {}, {}, PeerProof::not_a_peer);
    out.is_returned = true;
    return out;
  }

  /// Returns one line for a log, without control characters. An unproven name is shown as one that
  /// the peer "claims to be". The line ends with the event's name and code in brackets. Earlier
  /// text that looks like that has "\x5b" in place of its bracket.
  std::string to_line() const;
  /// Returns a JSON object on one line, in ASCII: time, code, name, severity, peer_subject,
  /// peer_authenticated, guid, document, line, field, expected, found, hint, sentence. Each text is
  /// at most 1024 octets long, plus "..." if it was cut. `at` is the calendar time of the event
  /// (Clock::calendar_nanoseconds), shown in UTC.
  std::string to_json(std::chrono::nanoseconds at) const;
};

/// True for events below a warning that a person who runs a program always wants to see: the
/// interfaces that a participant uses, which peers authenticated, and which documents change.
bool is_always_shown(Code code);

/// Receives events. `raise` is called from any thread. It must not call back into a plugin, and it
/// should return soon, because the participant that raises the event waits for it.
class EventSink {
 public:
  virtual ~EventSink() = default;
  /// Takes one event. The reference is valid only during the call. It may throw if memory runs out:
  /// the RateLimitedSink, which hosts put before their sinks, then drops the event, and what the
  /// event reports stands.
  virtual void raise(const Event& event) = 0;
};

}  // namespace ddssec
