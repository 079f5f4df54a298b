// What the agent reports: one JSON object a line, by "event of agent" in cli/schema. No event has a
// key, a request, a PIN, or what a hook wrote.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// Reports at once, on standard output, or keeps the events for a report.
class AgentEvents {
 public:
  enum class To : std::uint8_t { standard_output, report };
  AgentEvents(To to, const Clock& clock) : to_(to), clock_(clock) {}

  /// An event of the agent itself.
  void report(std::string_view event, Json members = Json::object());
  /// An event about a folder.
  void report(std::string_view event, const std::filesystem::path& folder, Json members);

  /// The events so far, with To::report.
  const Json& kept() const { return kept_; }

 private:
  void put(Json event);
  To to_;
  const Clock& clock_;
  Json kept_ = Json::array();
};

/// The members about an error: code, number, message, hint; file, if it is about one.
Json event_members(const Error& error);

}  // namespace ddssec::cli
