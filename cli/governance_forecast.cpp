#include "cli/governance_forecast.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "governance/live_change.hpp"

namespace ddssec::cli {
namespace {

/// In the order of severity.
enum class Live : std::uint8_t {
  same,
  live,
  live_unless_in_use,  ///< a rule comes before others: its topics may be in use
  live_if_believed,    ///< another CA signed it
  restart,
};

std::string_view live_word(Live live) {
  switch (live) {
    case Live::same:
      return "same";
    case Live::live:
      return "live";
    case Live::live_unless_in_use:
      return "live unless in use";
    case Live::live_if_believed:
      return "live if the signer is believed";
    case Live::restart:
      return "restart";
  }
  return "";
}

/// The most severe outcome, and the first reason for it.
struct Forecast {
  Live outcome = Live::same;
  std::string reason = {};
  int line = 0;  ///< of the new document

  void add(Live next, const std::string& why, int at) {
    if (next <= outcome) return;
    outcome = next;
    reason = why;
    line = at;
  }
};

void add_domain(const governance::DomainRule& before, const governance::DomainRule* after,
                Forecast& out) {
  if (after == nullptr) return out.add(Live::restart, "a domain has no rule any more", 0);
  const auto added = governance::added_topic_rules(before, *after);
  if (!added) {
    const auto& details = added.error().details();
    const auto why =
        details.field == "topic_rule"
            ? fmt::format("{} is not there", details.expected)
            : fmt::format("{}: {} became {}", details.field, details.expected, details.found);
    return out.add(Live::restart, why, details.line);
  }
  if (added->rules.empty()) return;
  const auto& first = *added->rules.front();
  out.add(added->are_last ? Live::live : Live::live_unless_in_use,
          fmt::format("a further rule for \"{}\"", first.topic_expression), first.line);
}

Forecast forecast(const governance::Governance& before, const governance::Governance& after) {
  std::set<std::string> tags{""};
  for (const auto* document : {&before, &after})
    for (const auto& rule : document->domain_rules)
      for (const auto& tag : rule.domains.tags) tags.insert(tag.text);
  Forecast out;
  for (DomainId domain = 0; domain <= governance::kHighestDomainId; ++domain)
    for (const auto& tag : tags)
      if (const auto* rule = before.find(domain, tag))
        add_domain(*rule, after.find(domain, tag), out);
  return out;
}

std::string_view in_words(Live live) {
  switch (live) {
    case Live::same:
      return "nothing changes";
    case Live::live:
      return "taken while they run";
    case Live::live_unless_in_use:
      return "taken while they run; restart those that use one of its topics";
    case Live::live_if_believed:
      return "refused, unless the new signer is one of their permissions CAs";
    case Live::restart:
      return "restart";
  }
  return "";
}

}  // namespace

void add_forecast(const governance::Governance& before, const governance::Governance& after,
                  const DiffSides& sides, Report& report) {
  auto ours = forecast(before, after);
  const auto &before_signer = sides.before.signer, &after_signer = sides.after.signer;
  if (!before_signer.empty() && !after_signer.empty() && before_signer != after_signer)
    ours.add(Live::live_if_believed, "another CA signed the new document", 0);
  const auto& result = report.result;
  const bool is_same =
      ours.outcome == Live::same && result["changes"].empty() && result["rewritten"].empty();
  const auto stock = is_same ? Live::same : Live::restart;
  constexpr std::string_view kHeading = "running participants: ";
  const auto reason = ours.reason.empty() ? std::string() : fmt::format("({})", shown(ours.reason));
  report.text +=
      wrapped(kHeading, {"on ddssec's plugins:", std::string(in_words(ours.outcome)), reason});
  report.text += wrapped(std::string(kHeading.size(), ' '),
                         {"on those of Cyclone DDS and Fast DDS:", std::string(in_words(stock))});
  report.result["live"] = {{"ddssec", live_word(ours.outcome)},
                           {"stock", live_word(stock)},
                           {"reason", ours.reason},
                           {"at", place(sides.after.path, ours.line)}};
}

}  // namespace ddssec::cli
