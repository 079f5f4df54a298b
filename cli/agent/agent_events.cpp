#include "cli/agent/agent_events.hpp"

#include "base/text.hpp"
#include "cli/agent/agent_messages.hpp"

namespace ddssec::cli {
namespace {

constexpr std::string_view kOctal = "01234567", kHexadecimal = "0123456789abcdef";
constexpr std::size_t kModeDigits = 4, kHashDigits = 64;

// Returns a member that is shown on a terminal as it is. Only zeros if it is not so many digits.
std::string digits_in(const Json& json, std::string_view name, std::string_view allowed,
                      std::size_t count) {
  auto out = text_in(json, name);
  const bool are_digits = out.size() == count && out.find_first_not_of(allowed) == out.npos;
  return are_digits ? out : std::string(count, '0');
}

}  // namespace

void AgentEvents::put(Json event) {
  if (to_ == To::report) return kept_.push_back({std::move(event)});
  output_.put(to_line(event) + '\n');
}

void AgentEvents::report(std::string_view event, Json members) {
  Json out = {
      {"schema", "ddssec/2"}, {"time", to_string(clock_.calendar_seconds())}, {"event", event}};
  out.update(members);
  put(std::move(out));
}

void AgentEvents::report(std::string_view event, const std::filesystem::path& folder,
                         Json members) {
  Json all = {{"folder", folder.string()}};
  all.update(members);
  report(event, std::move(all));
}

Json known_members(const Json& event) {
  constexpr std::size_t kMaxText = 4096, kMaxFiles = 8;
  Json out = Json::object();
  for (const auto* name :
       {"event", "subject", "serial", "not_after", "next", "sha256", "ocsp_until", "ocsp_silent"})
    if (event.contains(name)) out[name] = text_in(event, name).substr(0, kMaxText);
  for (const auto* name : {"rekeyed", "permissions_extended", "restart_needed"})
    if (event.contains(name)) out[name] = event[name] == true;
  if (event.contains("problem")) out["problem"] = error_to_json(reported_error(event["problem"]));
  if (!event.contains("files")) return out;
  out["files"] = Json::array();
  for (const auto& file : event["files"])
    if (out["files"].size() < kMaxFiles && file.is_object())
      out["files"].push_back({{"path", text_in(file, "path").substr(0, kMaxText)},
                              {"mode", digits_in(file, "mode", kOctal, kModeDigits)},
                              {"sha256", digits_in(file, "sha256", kHexadecimal, kHashDigits)}});
  return out;
}

std::vector<WrittenFile> files_from(const Json& event) {
  std::vector<WrittenFile> out;
  if (!event.contains("files")) return out;
  for (const auto& file : event["files"])
    out.push_back({.path = text_in(file, "path"),
                   .mode = text_in(file, "mode"),
                   .sha256 = text_in(file, "sha256")});
  return out;
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
