// The services that every plugin context gets from its host: clocks, randomness, and the output of
// events.
#pragma once

#include <memory>

#include "base/clock.hpp"
#include "base/event.hpp"
#include "base/plugin_services.hpp"
#include "base/rate_limited_sink.hpp"
#include "base/steady_calendar.hpp"
#include "plugins/cyclonedds/host_log.hpp"

namespace ddssec::cyclonedds {

/// The services of one plugin context. It must outlive the plugin. Thread-safe.
class Host {
 public:
  /// `log` receives the events that pass the rate limit. `code` is an address in the host's code,
  /// or null.
  explicit Host(std::unique_ptr<EventSink> log, const void* code = nullptr)
      : code_(code), log_(std::move(log)), limited_(*log_, clock_), counted_(limited_) {}
  /// Returns the services with the record of DDSSEC_STATUS_DIR; call it before the plugin is made.
  /// If `reports`, an event gives the reason if there is none although the variable requests it.
  const PluginServices& services_with_record(bool reports);
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  /// Returns the services for the plugin, which this object owns.
  const PluginServices& services() const { return services_; }
  const Clock& clock() const { return calendar_; }
  SteadyCalendar& calendar() { return calendar_; }
  const void* code() const { return code_; }

  /// Raises one event; ignores all exceptions.
  void refused(const Error& error, Severity severity) noexcept;

  /// Raises an event that belongs to no refusal. It does not count as the event of the call that is
  /// under way.
  void notice(const Event& event) noexcept;

  /// Returns the number of events that the calling thread has raised so far, by any plugin of this
  /// library.
  static unsigned raised_by_this_thread() noexcept;

 private:
  class CountingSink final : public EventSink {
   public:
    explicit CountingSink(RateLimitedSink& next) : next_(next) {}
    void raise(const Event& event) override;

   private:
    RateLimitedSink& next_;
  };

  const void* const code_;
  SystemClock clock_;
  SteadyCalendar calendar_{clock_};
  SystemRandom random_;
  std::unique_ptr<EventSink> log_;
  RateLimitedSink limited_;
  CountingSink counted_;
  std::shared_ptr<DocumentsInUse> documents_;  ///< nullptr if the process shows none
  PluginServices services_{calendar_, random_, counted_};
};

}  // namespace ddssec::cyclonedds
