#include "base/event_log.hpp"

#include <cstdlib>
#include <utility>

#include "base/clock.hpp"

namespace ddssec {

EventLog::EventLog(const char* path) : lost_(std::make_unique<std::atomic<std::uint64_t>>(0)) {
  if (path == nullptr || *path == '\0') return;
  path_ = path;
  file_ = std::make_unique<LineFile>(path);
  if (file_->is_open()) return;
  write_failure_ = about_the_file("a file, a FIFO with a reader, or a terminal", file_->why_not());
  file_.reset();
}

EventLog EventLog::of_environment() { return EventLog(std::getenv("DDSSEC_EVENT_LOG")); }

std::optional<Event> EventLog::append(const Event& event) {
  if (!file_) return std::nullopt;
  const auto now = SystemClock().calendar_nanoseconds();
  if (!file_->append(event.to_json(now))) {
    if (lost_->fetch_add(1) != 0) return std::nullopt;
    return about_the_file("room for an event", "no room, or no reader that keeps up");
  }
  const auto lost = lost_->exchange(0);
  if (lost == 0) return std::nullopt;
  auto told =
      about_the_file("every event", std::to_string(lost) + " events before this one are lost");
  file_->append(told.to_json(now));
  return told;
}

Event EventLog::about_the_file(std::string expected, std::string found) const {
  return Event(
      Error(Code::event_log_unwritable,
            {.document = path_, .expected = std::move(expected), .found = std::move(found)}));
}

LoggedEvents::LoggedEvents(EventSink& next, EventLog log) : next_(next), log_(std::move(log)) {
  if (log_.write_failure()) next_.raise(*log_.write_failure());
}

void LoggedEvents::raise(const Event& event) {
  next_.raise(event);
  if (const auto about_the_file = log_.append(event)) next_.raise(*about_the_file);
}

}  // namespace ddssec
