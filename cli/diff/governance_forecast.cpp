#include "cli/diff/governance_forecast.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "cli/diff/forecast.hpp"
#include "governance/compare/name_kinds.hpp"
#include "governance/live_change.hpp"

namespace ddssec::cli {
namespace {

// The outcomes in the order of severity.
enum class Live : std::uint8_t {
  same,
  live,
  two_phases,          // topics are protected more
  live_unless_in_use,  // a rule comes before others, or protects more: its topics may be in use
  live_if_signer_accepted,  // another CA signed it
  rolled_back,              // its revision is not higher than the former one
  no_revision,              // it is signed without a revision, but needs one
  restart,
};

std::string_view live_word(Live live) {
  switch (live) {
    case Live::same:
      return "same";
    case Live::live:
      return "live";
    case Live::two_phases:
      return "two phases";
    case Live::live_unless_in_use:
      return "live unless in use";
    case Live::live_if_signer_accepted:
      return "live if the signer is believed";
    case Live::rolled_back:
      return "refused as a roll-back";
    case Live::no_revision:
      return "refused without a revision";
    case Live::restart:
      return "restart";
  }
  return "";
}

using Prediction = Forecast<Live>;

// The predictions for both hosts of ddssec's plugins.
struct Forecasts {
  Prediction embedded, cyclonedds;
  bool raises = false;     // true if an existing rule protects more
  bool is_phased = false;  // true if two phases are needed, whatever the revision

  void add(Live next, const std::string& why, int at) {
    embedded.add(next, why, at);
    cyclonedds.add(next, why, at);
  }
  const Prediction& worse() const {
    return embedded.outcome > cyclonedds.outcome ? embedded : cyclonedds;
  }
};

void add_domain(const governance::DomainRule& before, const governance::DomainRule* after,
                Forecasts& out) {
  if (after == nullptr) return out.add(Live::restart, "a domain has no rule any more", 0);
  const auto added = governance::live_change(before, *after);
  if (!added) {
    const auto& details = added.error().details();
    const auto why =
        details.field == "topic_rule"
            ? fmt::format("{} is not there", details.expected)
            : fmt::format("{}: {} became {}", details.field, details.expected, details.found);
    return out.add(Live::restart, why, details.line);
  }
  if (!added->raised.empty()) {
    out.raises = true;
    const auto& raised = *added->raised.front();
    const auto why = fmt::format("more protection for \"{}\"", raised.topic_expression);
    out.embedded.add(Live::two_phases, why, raised.line);
    out.cyclonedds.add(Live::live_unless_in_use, why, raised.line);
  }
  if (added->rules.empty()) return;
  const auto& first = *added->rules.front();
  const auto why = fmt::format("a further rule for \"{}\"", first.topic_expression);
  const auto unless_in_use = added->fit_in_use ? Live::two_phases : Live::live_unless_in_use;
  if (added->are_last || added->are_alike) return out.add(Live::live, why, first.line);
  out.embedded.add(unless_in_use, why, first.line);
  out.cyclonedds.add(Live::live_unless_in_use, why, first.line);
}

// Predicts for a signed document without a revision. A document that is not signed yet gets the
// next revision.
void add_missing_revision(const governance::Governance& before, const DiffSides& sides,
                          Forecasts& out) {
  if (!sides.after.is_signed || sides.after.text == sides.before.text) return;
  if (before.revision > 0)
    return out.add(
        Live::no_revision,
        fmt::format("the old document has revision {}, the new one none", before.revision), 0);
  if (out.raises) return out.add(Live::no_revision, "more protection needs a revision", 0);
  if (out.embedded.outcome == Live::two_phases)
    out.embedded.add(Live::live_unless_in_use, out.embedded.reason, out.embedded.line);
}

// A document with the same revision as the former one must have the same content.
void add_revision(const governance::Governance& before, const governance::Governance& after,
                  const DiffSides& sides, Forecasts& out) {
  if (after.revision == 0) return add_missing_revision(before, sides, out);
  const bool is_same = out.worse().outcome == Live::same;
  if (after.revision > before.revision || (after.revision == before.revision && is_same)) return;
  out.add(Live::rolled_back,
          fmt::format("revision {} does not follow {}", after.revision, before.revision), 0);
}

Forecasts forecast(const governance::Governance& before, const governance::Governance& after,
                   const DiffSides& sides) {
  std::set<std::string> tags{""};
  std::vector<std::string> expressions;
  for (const auto* document : {&before, &after})
    for (const auto& rule : document->domain_rules) {
      for (const auto& tag : rule.domains.tags) tags.insert(tag.text);
      for (const auto& tag : rule.domains.tag_expressions) expressions.push_back(tag.text);
    }
  Forecasts out;
  // Tries one example for each kind of tag that the expressions distinguish.
  const auto kinds = governance::NameKinds::of(std::move(expressions));
  if (!kinds) out.add(Live::restart, "there are too many expressions of tags to compare", 0);
  for (governance::NameKinds::Kind kind = 0; kinds && kind < kinds->size(); ++kind)
    tags.insert(kinds->example(kind));
  for (DomainId domain = 0; domain <= governance::kMaxDomainId; ++domain)
    for (const auto& tag : tags)
      if (const auto* rule = before.find(domain, tag))
        add_domain(*rule, after.find(domain, tag), out);
  out.is_phased = out.embedded.outcome == Live::two_phases;
  add_revision(before, after, sides, out);
  return out;
}

std::string_view outcome_text(Live live, bool is_ready) {
  switch (live) {
    case Live::same:
      return "nothing changes";
    case Live::live:
      return "taken while they run";
    case Live::two_phases:
      return is_ready ? "taken while they run, in two phases"
                      : "taken while they run, in two phases, once it is signed: ddssec governance "
                        "sign writes the revision that it needs";
    case Live::live_unless_in_use:
      return "taken while they run; restart those that use one of its topics";
    case Live::live_if_signer_accepted:
      return "refused, unless the new signer is one of their permissions CAs";
    case Live::rolled_back:
      return "refused as a roll-back: sign it anew";
    case Live::no_revision:
      return "refused: ddssec governance sign writes the revision that it lacks";
    case Live::restart:
      return "restart";
  }
  return "";
}

}  // namespace

GovernanceForecast forecast_of(const governance::Governance& before,
                               const governance::Governance& after, const DiffSides& sides,
                               bool is_same) {
  auto ours = forecast(before, after, sides);
  const auto &before_signer = sides.before.signer, &after_signer = sides.after.signer;
  if (!before_signer.empty() && !after_signer.empty() && before_signer != after_signer)
    ours.add(Live::live_if_signer_accepted, "another CA signed the new document", 0);
  const auto& worse = ours.worse();
  const auto stock = is_same && worse.outcome == Live::same ? Live::same : Live::restart;
  const bool is_ready = sides.after.is_signed || after.revision != 0;
  GovernanceForecast out{.ddssec = live_word(worse.outcome),
                         .embedded = live_word(ours.embedded.outcome),
                         .cyclonedds = live_word(ours.cyclonedds.outcome),
                         .stock = live_word(stock),
                         .reason = worse.reason,
                         .at = place(sides.after.path, worse.line),
                         .is_phased = ours.is_phased};
  std::string heading = "running participants: ";
  const auto add = [&](std::string host, const Prediction& what) {
    const auto reason =
        what.reason.empty() ? std::string() : fmt::format("({})", name_text(what.reason));
    out.text += wrapped(
        heading, {std::move(host), std::string(outcome_text(what.outcome, is_ready)), reason});
    heading = std::string(heading.size(), ' ');
  };
  if (ours.embedded.outcome == ours.cyclonedds.outcome) {
    add("on ddssec's plugins:", worse);
  } else {
    add("embedded participants of ddssec:", ours.embedded);
    add("Cyclone DDS on ddssec's plugins:", ours.cyclonedds);
  }
  add("on those of Cyclone DDS and Fast DDS:", {.outcome = stock});
  return out;
}

}  // namespace ddssec::cli
