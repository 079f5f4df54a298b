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

/// One refusal or notice.
struct Event {
  Error error;
  Severity severity;
  std::string peer_subject;  ///< subject name of the other side, RFC 2253; empty = local or unknown
  std::string guid;          ///< whose GUID, if known

  Event(Error reason, std::string subject = {}, std::string whose_guid = {})
      : error(std::move(reason)),
        severity(info(error.code()).severity),
        peer_subject(std::move(subject)),
        guid(std::move(whose_guid)) {}

  /// One line for a log.
  std::string to_line() const;
  /// A JSON object of one line: code, name, severity, peer_subject, guid, document, line, field,
  /// expected, found, hint, sentence.
  std::string to_json() const;
};

/// Takes events; called from any thread, must not block and must not call back into a plugin.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void raise(const Event& event) = 0;
};

/// Passes an event on unless the same {code, peer, GUID, document, field, values} went through less
/// than `interval` ago. Remembers at most kMostRemembered different ones; beyond that it lets one
/// event each interval through for all the unknown ones together.
class RateLimitedSink final : public EventSink {
 public:
  static constexpr std::size_t kMostRemembered = 1024;

  RateLimitedSink(EventSink& next, const Clock& clock,
                  std::chrono::seconds interval = std::chrono::seconds(10))
      : next_(next), clock_(clock), interval_(interval) {}
  void raise(const Event& event) override;

 private:
  bool may_pass(const std::string& key);

  EventSink& next_;
  const Clock& clock_;
  const std::chrono::nanoseconds interval_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::chrono::nanoseconds> last_;
};

/// What every engine is built with; all three outlive it.
struct Environment {
  const Clock& clock;
  Random& random;
  EventSink& events;
};

}  // namespace ddssec
