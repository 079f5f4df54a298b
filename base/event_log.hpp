// The file that the environment variable DDSSEC_EVENT_LOG names: a JSON object for each event.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/event.hpp"
#include "base/event_file.hpp"

namespace ddssec {

/// Thread-safe.
class EventLog {
 public:
  /// `path`: of the file; no events are written if it is null or empty.
  explicit EventLog(const char* path);
  /// The file that DDSSEC_EVENT_LOG names now.
  static EventLog of_environment();

  /// If there is a path, and the file cannot be written: an event that says so.
  const std::optional<Event>& write_failure() const { return write_failure_; }

  /// Writes the event with the present time. A full disk or a slow reader must not stop a refusal:
  /// the first line that is lost, and the number of lost ones when lines can be written again, are
  /// returned as an event for another log.
  std::optional<Event> append(const Event& event);

 private:
  Event about_the_file(std::string expected, std::string found) const;

  std::string path_;
  std::unique_ptr<EventFile> file_;  ///< null: no events are written
  std::optional<Event> write_failure_;
  std::unique_ptr<std::atomic<std::uint64_t>> lost_;  ///< events, since lines went in
};

/// Passes each event on, and writes it into an event log.
class LoggedEvents final : public EventSink {
 public:
  LoggedEvents(EventSink& next, EventLog log);
  void raise(const Event& event) override;

 private:
  EventSink& next_;
  EventLog log_;
};

}  // namespace ddssec
