// What a program with a participant needs around it, put together in one place.
#pragma once

#include "base/event_log.hpp"
#include "base/plugin_services.hpp"
#include "base/rate_limited_sink.hpp"
#include "secured/security_plugin_set.hpp"

namespace ddssec::secured {

/// The clock, random source, events and security plugins of a program. Must outlive the
/// participants that use them. Thread-safe.
class Runtime {
 public:
  /// `events` gets the events, limited in rate, and must outlive this object. The file that
  /// DDSSEC_EVENT_LOG names gets them, too.
  explicit Runtime(EventSink& events) : logged_(events, EventLog::of_environment()) {}
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  const Clock& clock() const { return clock_; }
  Random& random() { return random_; }
  /// Returns the sink for events: the one that limits the rate.
  EventSink& events() { return limited_; }
  /// Returns what plugins and participants take. It refers to this object.
  PluginServices services() { return {clock_, random_, limited_}; }
  SecurityPluginSet& plugins() { return plugins_; }

 private:
  SystemClock clock_;
  SystemRandom random_;
  LoggedEvents logged_;
  RateLimitedSink limited_{logged_, clock_};
  SecurityPluginSet plugins_{services()};
};

}  // namespace ddssec::secured
