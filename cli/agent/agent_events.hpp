// The agent's reports: one JSON object for each line, as "event of agent" in cli/schema describes
// it. No event contains a key, a request, a PIN, or what a hook wrote.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "cli/agent/event_output.hpp"
#include "cli/frame/answer.hpp"

namespace ddssec::cli {

/// An event. Most events come from a process of another user, so the agent keeps only members that
/// it knows.
struct AgentEvent {
  static constexpr std::string_view kDef = "event of agent";
  Json members;

  const Json& json() const { return members; }
};

/// The result of `agent --once`.
struct AgentRun {
  std::vector<AgentEvent> events = {};

  static constexpr auto fields() {
    return std::tuple(
        field<&AgentRun::events>({"with `--once`: the lines that it prints without `--format json` "
                                  "([each](../docs/agent.md#3-events))"}));
  }
  static std::string text() { return {}; }
};

/// Writes events to standard output at once, or keeps them for a report.
class AgentEvents {
 public:
  enum class To : std::uint8_t { standard_output, report };
  AgentEvents(To to, const Clock& clock) : to_(to), clock_(clock) {}

  /// Reports an event of the agent itself.
  void report(std::string_view event, Json members = Json::object());
  /// Reports an event about a folder.
  void report(std::string_view event, const std::filesystem::path& folder, Json members);

  /// Returns the events so far, with To::report.
  const std::vector<AgentEvent>& kept() const { return kept_; }

 private:
  void put(Json event);
  To to_;
  const Clock& clock_;
  EventOutput output_ = EventOutput();
  std::vector<AgentEvent> kept_;
};

/// Returns the members that the agent reports of an event. They are shortened, because a process
/// with another user's rights has sent them.
Json known_members(const Json& event);
/// Returns the files in the event's member "files".
std::vector<WrittenFile> files_from(const Json& event);

/// Returns the members about an error: code, number, message and hint, and the file if the error
/// names one.
Json event_members(const Error& error);

}  // namespace ddssec::cli
