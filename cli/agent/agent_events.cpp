#include "cli/agent/agent_events.hpp"

#include <cstdio>

#include "base/text.hpp"
#include "cli/agent/agent_messages.hpp"

namespace ddssec::cli {

void AgentEvents::put(Json event) {
  if (to_ == To::report) return kept_.push_back({std::move(event)});
  const auto line = to_line(event) + '\n';
  std::fwrite(line.data(), 1, line.size(), stdout);
  std::fflush(stdout);
}

void AgentEvents::report(std::string_view event, Json members) {
  Json out = {{"schema", "ddssec/1"}, {"time", to_string(clock_.now())}, {"event", event}};
  out.update(members);
  put(std::move(out));
}

void AgentEvents::report(std::string_view event, const std::filesystem::path& folder,
                         Json members) {
  Json all = {{"folder", folder.string()}};
  all.update(members);
  report(event, std::move(all));
}

Json event_members(const Error& error) {
  const auto& row = info(error.code());
  const auto& details = error.details();
  const auto message =
      details.field.empty() ? error.message() : details.field + ": " + error.message();
  Json out = {{"code", row.name},
              {"number", static_cast<int>(row.code)},
              {"message", printable(message)},
              {"hint", printable(hint_of(error))}};
  if (!details.document.empty()) out["file"] = details.document;
  return out;
}

}  // namespace ddssec::cli
