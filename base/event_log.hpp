// The file that the environment variable DDSSEC_EVENT_LOG names: a JSON object for each event.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/event.hpp"
#include "base/line_file.hpp"

namespace ddssec {

/// Writes events into that file. Thread-safe.
class EventLog {
 public:
  /// Opens the file at `path`. If `path` is null or empty, no events are written.
  explicit EventLog(const char* path);
  /// Opens the file that DDSSEC_EVENT_LOG names now.
  static EventLog of_environment();

  /// Returns the event about a file that cannot be written, or nothing.
  const std::optional<Event>& write_failure() const { return write_failure_; }

  /// Writes the event with the present time. A full disk or a slow reader must not stop a refusal.
  /// Returns an event for another log when the first line is lost, and another one with the number
  /// of lost lines when lines can be written again.
  std::optional<Event> append(const Event& event);

 private:
  Event about_the_file(std::string expected, std::string found) const;

  std::string path_;
  std::unique_ptr<LineFile> file_;  ///< null if no events are written
  std::optional<Event> write_failure_;
  std::unique_ptr<std::atomic<std::uint64_t>> lost_;  ///< lost since the last line
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
