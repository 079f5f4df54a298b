#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "governance/lint_grant.hpp"
#include "governance/pattern.hpp"
#include "governance/shadowed_expressions.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;

constexpr std::string_view kRequest = "Request", kReply = "Reply";

// True if the grant names a ROS topic. The discovery topic alone does not count, because these
// checks report its absence.
bool names_ros_topics(const GrantPlace& place) {
  return std::ranges::any_of(place.actions(), [](const auto& entries) {
    return std::ranges::any_of(entries, [](const GrantEntry& entry) {
      const std::string_view text = entry.topic->text;
      return text.starts_with("rt/") || text.starts_with("rq/") || text.starts_with("rr/");
    });
  });
}

// Returns rr/NAMEReply for rq/NAMERequest, and the other way round.
std::optional<std::string> other_half(std::string_view text) {
  const auto inside = [&](std::string_view end) {
    return std::string(text.substr(3, text.size() - 3 - end.size()));
  };
  if (text.starts_with("rq/") && text.ends_with(kRequest))
    return "rr/" + inside(kRequest).append(kReply);
  if (text.starts_with("rr/") && text.ends_with(kReply))
    return "rq/" + inside(kReply).append(kRequest);
  return std::nullopt;
}

// Reports halves of services whose other half is not allowed in the other direction.
void diagnose_services(LintFindings& out, const GrantPlace& place, std::size_t action) {
  std::vector<const GrantEntry*> halves;
  std::vector<std::string> others;
  for (const auto& entry : place.actions()[action]) {
    const auto other = entry.rule->allow ? other_half(entry.topic->text) : std::nullopt;
    if (!other) continue;
    halves.push_back(&entry);
    others.push_back(*other);
  }
  auto texts = allowed_texts(place.actions()[1 - action]);
  const auto allowed = texts.size();
  texts.insert(texts.end(), others.begin(), others.end());
  const auto found =
      shadows(texts, out.effort(), [&](std::uint32_t a, std::uint32_t) { return a < allowed; });
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const bool is_undecided = out.effort().steps == 0;
    if (found[allowed + i].is_dead || is_undecided) continue;
    out.add(place.about(PERM030, *halves[i],
                        fmt::format("to {} {} is allowed, to {} {} is not", kActionNames.at(action),
                                    in_quotes(halves[i]->topic->text), kActionNames.at(1 - action),
                                    in_quotes(others[i]))));
  }
}

bool allows(const std::vector<GrantEntry>& entries, std::string_view name) {
  return std::ranges::any_of(entries, [&](const GrantEntry& entry) {
    return entry.rule->allow && Pattern(entry.topic->text).matches(name);
  });
}

void diagnose_discovery(LintFindings& out, const GrantPlace& place) {
  constexpr std::string_view kTopic = "ros_discovery_info";
  for (const auto action : {0u, 1u})
    if (!allows(place.actions()[action], kTopic))
      out.add(place.about(
          PERM032, fmt::format("to {} ros_discovery_info is not allowed", kActionNames[action])));
}

void diagnose_log_topic(LintFindings& out, const GrantPlace& place) {
  if (allows(place.publish(), "rt/rosout")) return;
  for (const auto& entry : place.publish()) {
    const std::string_view text = entry.topic->text;
    if (entry.rule->allow && text.starts_with("rt/") && text.ends_with("/rosout"))
      out.add(place.about(
          PERM033, entry,
          fmt::format("{} is allowed, and rt/rosout, where nodes log, is not", in_quotes(text))));
  }
}

}  // namespace

void lint_ros(LintFindings& out, const GrantPlace& place) {
  if (!names_ros_topics(place)) return;
  diagnose_services(out, place, 0);
  diagnose_services(out, place, 1);
  diagnose_discovery(out, place);
  diagnose_log_topic(out, place);
}

}  // namespace ddssec::governance
