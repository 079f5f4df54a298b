// What the agent reports: one JSON object a line, by "event of agent" in cli/schema. No event has a
// key, a request, a PIN, or what a hook wrote.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "cli/frame/answer.hpp"

namespace ddssec::cli {

/// An event. Most come from a process of another user, so the agent keeps only members that it
/// knows.
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
  const std::vector<AgentEvent>& kept() const { return kept_; }

 private:
  void put(Json event);
  To to_;
  const Clock& clock_;
  std::vector<AgentEvent> kept_;
};

/// Those members that the agent reports of an event, shortened: a process with another user's
/// rights has sent it.
Json known_members(const Json& event);
/// The files in its member "files".
std::vector<WrittenFile> files_from(const Json& event);

/// The members about an error: code, number, message, hint; file, if it is about one.
Json event_members(const Error& error);

}  // namespace ddssec::cli
