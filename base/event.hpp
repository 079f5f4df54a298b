// Events: the messages for the operator of a system, one for each refusal.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Whether a peer has proven the subject name that an event gives it.
enum class PeerProof : std::uint8_t {
  claimed,        ///< the name comes from an announcement, which anyone can send
  authenticated,  ///< the name is in the certificate with which the peer authenticated
  not_a_peer      ///< the event is about the local participant or about no participant
};

/// One refusal or notice.
struct Event {
  Error error;
  Severity severity;
  std::string peer_subject;  ///< subject name of the peer; empty: local or unknown
  std::string guid;          ///< GUID of the participant concerned; empty: unknown
  PeerProof proof;
  bool is_returned = false;  ///< the application also receives the error as the result of its call

  Event(Error reason, std::string subject = {}, std::string whose_guid = {},
        PeerProof subject_proof = PeerProof::claimed)
      : error(std::move(reason)),
        severity(info(error.code()).severity),
        peer_subject(std::move(subject)),
        guid(std::move(whose_guid)),
        proof(subject_proof) {}

  /// The event for an error that the application also receives as the result of its call. A log of
  /// events includes it. A program that prints both its events and its errors leaves it out.
  static Event of_returned(Error reason) {
    Event out(std::move(reason), {}, {}, PeerProof::not_a_peer);
    out.is_returned = true;
    return out;
  }

  /// One line for a log, without control characters. An unproven name is shown as one that the peer
  /// "claims to be". The line ends with the event's name and code in brackets. Earlier text that
  /// looks like that has "\x5b" in place of its bracket.
  std::string to_line() const;
  /// A JSON object on one line, in ASCII: time, code, name, severity, peer_subject,
  /// peer_authenticated, guid, document, line, field, expected, found, hint, sentence. Each text is
  /// at most 1024 octets long, plus "..." for what was cut off. `at`: calendar time of the event
  /// (Clock::wall), shown in UTC.
  std::string to_json(std::chrono::nanoseconds at) const;
};

/// True for events below a warning that a person who runs a program wants to see in any case: who
/// authenticated, and which documents were renewed.
bool is_news(Code code);

/// Receives events. `raise` is called from any thread; it must not block and must not call back
/// into a plugin.
class EventSink {
 public:
  virtual ~EventSink() = default;
  /// Takes one event. The reference is valid only during the call. Must not throw.
  virtual void raise(const Event& event) = 0;
};

/// Passes an event on, unless an event with the same reason about the same peer was passed on less
/// than `interval` ago. Thread-safe.
///
/// The reason consists of the code and the document. If no unauthenticated peer can have chosen
/// them, the field and the expected value also count. The found value and names that are only
/// claimed never count (exception: the found value of informational notices about the local
/// participant).
///
/// Memory is bounded in shares, so that no peer can suppress events about others. There is one
/// share for the local participant and one for all peers without proof. Each authenticated peer has
/// one share for each code, because it chooses the names of its topics and partitions. If a share
/// is full, or there are more than kMaxRemembered shares of peers, each code is still passed on
/// once in each interval.
class RateLimitedSink final : public EventSink {
 public:
  /// About the local participant; also the number of shares of authenticated peers.
  static constexpr std::size_t kMaxRemembered = 1024;
  static constexpr std::size_t kMaxClaimed = 128;  ///< about all unauthenticated peers together
  static constexpr std::size_t kMaxOfAPeer = 16;   ///< about one authenticated peer, for each code

  RateLimitedSink(EventSink& next, const Clock& clock,
                  std::chrono::seconds interval = std::chrono::seconds(10))
      : next_(next), clock_(clock), interval_(interval) {}
  void raise(const Event& event) override;

 private:
  using Times = std::unordered_map<std::string, std::chrono::nanoseconds>;

  Times& share_of(const std::string& peer, std::chrono::nanoseconds now);
  bool has_room(Times& share, std::size_t limit, const std::string& reason,
                std::chrono::nanoseconds now) const;
  bool may_pass(Times& share, const std::string& reason, std::chrono::nanoseconds now) const;
  void forget_old(Times& share, std::chrono::nanoseconds now) const;

  EventSink& next_;
  const Clock& clock_;
  const std::chrono::nanoseconds interval_;
  std::mutex mutex_;
  Times ours_;
  Times claimed_;
  std::unordered_map<std::string, Times> proven_;  // by code and subject name
  Times no_share_;
  Times crowded_out_;  // by code; there are few
};

class DocumentsInUse;

/// The services that every engine gets at construction. All of them must outlive it.
struct EngineServices {
  const Clock& clock;
  Random& random;
  EventSink& events;
  DocumentsInUse* documents = nullptr;  ///< where the engine notes its documents; null: nowhere
};

}  // namespace ddssec
