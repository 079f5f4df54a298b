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

  Event(Error reason, std::string subject = {}, std::string whose_guid = {},
        PeerProof subject_proof = PeerProof::claimed)
      : error(std::move(reason)),
        severity(info(error.code()).severity),
        peer_subject(std::move(subject)),
        guid(std::move(whose_guid)),
        proof(subject_proof) {}

  /// One line for a log, without control characters. A name that is not proven is one that the peer
  /// "claims to be".
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
/// Remembers at most kMostRemembered different events, of peers without proof kMostClaimed apart
/// from the others; beyond that one event each interval goes through for all the unknown ones.
class RateLimitedSink final : public EventSink {
 public:
  static constexpr std::size_t kMostRemembered = 1024;
  static constexpr std::size_t kMostClaimed = 128;

  RateLimitedSink(EventSink& next, const Clock& clock,
                  std::chrono::seconds interval = std::chrono::seconds(10))
      : next_(next), clock_(clock), interval_(interval) {}
  void raise(const Event& event) override;

 private:
  using Times = std::unordered_map<std::string, std::chrono::nanoseconds>;

  bool may_pass(Times& last, std::size_t most, const std::string& key);

  EventSink& next_;
  const Clock& clock_;
  const std::chrono::nanoseconds interval_;
  std::mutex mutex_;
  Times last_;
  Times last_claimed_;  // an attacker who invents peers crowds out none but such
};

/// What every engine is built with; all three outlive it.
struct Environment {
  const Clock& clock;
  Random& random;
  EventSink& events;
};

}  // namespace ddssec
