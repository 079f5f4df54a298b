// What a person responsible for the system is told: one event for each refusal.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <unordered_map>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Whether a peer has proven the subject name that an event gives it.
enum class PeerProof : std::uint8_t {
  claimed,        ///< the name is what an announcement says, which anyone can send
  authenticated,  ///< the name is that of the certificate with which the peer authenticated
  not_a_peer      ///< the GUID is our own
};

/// One refusal or notice.
struct Event {
  Error error;
  Severity severity;
  std::string peer_subject;  ///< subject name of the other side; empty = local or unknown
  std::string guid;          ///< whose GUID, if known
  PeerProof proof;
  bool is_returned = false;  ///< the application also gets the error, as the result of its call

  Event(Error reason, std::string subject = {}, std::string whose_guid = {},
        PeerProof subject_proof = PeerProof::claimed)
      : error(std::move(reason)),
        severity(info(error.code()).severity),
        peer_subject(std::move(subject)),
        guid(std::move(whose_guid)),
        proof(subject_proof) {}

  /// The event of an error that the application also gets, as the result of its call. A log of
  /// events keeps it; a program that prints both its events and its errors leaves it out.
  static Event of_returned(Error reason) {
    Event out(std::move(reason), {}, {}, PeerProof::not_a_peer);
    out.is_returned = true;
    return out;
  }

  /// One line for a log, without control characters. A name that is not proven is one that the peer
  /// "claims to be". It ends with the event's name and code in brackets; what looks like them
  /// before has "\x5b" for its bracket.
  std::string to_line() const;
  /// A JSON object of one line, in ASCII: code, name, severity, peer_subject, peer_authenticated,
  /// guid, document, line, field, expected, found, hint, sentence.
  std::string to_json() const;
};

/// Takes events; called from any thread, must not block and must not call back into a plugin.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void raise(const Event& event) = 0;
};

/// Passes an event on unless one with the same reason about the same peer went through less than
/// `interval` ago. Reason: code and document; where no unauthenticated peer can have chosen them,
/// also field and expected value. Never what was found, nor a name that is only claimed.
///
/// What is remembered is bounded in shares, so that no peer crowds out events about others: one
/// for ourselves, one for all peers without proof, and one for each code of each authenticated
/// peer, which chooses the names of its topics and partitions. Of a full share, and of peers beyond
/// kMostRemembered, each code still goes through once in each interval.
class RateLimitedSink final : public EventSink {
 public:
  static constexpr std::size_t kMostRemembered = 1024;  ///< about ourselves; shares of peers
  static constexpr std::size_t kMostClaimed = 128;      ///< about all peers without proof
  static constexpr std::size_t kMostOfAPeer = 16;       ///< about an authenticated peer, each code

  RateLimitedSink(EventSink& next, const Clock& clock,
                  std::chrono::seconds interval = std::chrono::seconds(10))
      : next_(next), clock_(clock), interval_(interval) {}
  void raise(const Event& event) override;

 private:
  using Times = std::unordered_map<std::string, std::chrono::nanoseconds>;

  Times& share_of(const std::string& peer, std::chrono::nanoseconds now);
  bool has_room(Times& share, std::size_t most, const std::string& reason,
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

/// What every engine is built with; all three outlive it.
struct Environment {
  const Clock& clock;
  Random& random;
  EventSink& events;
};

}  // namespace ddssec
