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
enum class GovernanceOutcome : std::uint8_t {
  same,
  live,
  two_phases,          // topics or the domain are protected more
  live_unless_in_use,  // a rule comes before others, or protects more: its topics may be in use
  live_if_signer_accepted,  // another CA signed it
  rolled_back,              // its revision is not higher than the former one
  no_revision,              // it is signed without a revision, but needs one
  restart,
};

constexpr OutcomeWords<GovernanceOutcome> kGovernanceWords[] = {
    {GovernanceOutcome::same, "same", "nothing changes"},
    {GovernanceOutcome::live, "live", "taken while they run"},
    {GovernanceOutcome::two_phases, "two phases", "taken while they run, in two phases"},
    {GovernanceOutcome::live_unless_in_use, "live unless in use",
     "taken while they run; restart those that use one of its topics"},
    {GovernanceOutcome::live_if_signer_accepted, "live if the signer is believed",
     "refused, unless the new signer is one of their permissions CAs"},
    {GovernanceOutcome::rolled_back, "refused as a roll-back",
     "refused as a roll-back: sign it again"},
    {GovernanceOutcome::no_revision, "refused without a revision",
     "refused: ddssec governance sign writes the revision that it lacks"},
    {GovernanceOutcome::restart, "restart", "restart"}};

std::string_view live_word(GovernanceOutcome live) { return words_of(kGovernanceWords, live).word; }

using Prediction = Forecast<GovernanceOutcome>;

// The predictions for both hosts of ddssec's plugins.
struct Forecasts {
  Prediction embedded, cyclonedds;
  bool raises = false;     // true if an existing rule or the domain protects more
  bool is_phased = false;  // true if two phases are needed, whatever the revision

  void add(GovernanceOutcome next, const std::string& why, int at) {
    embedded.add(next, why, at);
    cyclonedds.add(next, why, at);
  }
  const Prediction& worse() const {
    return embedded.outcome > cyclonedds.outcome ? embedded : cyclonedds;
  }
};

void add_domain(const governance::DomainRule& before, const governance::DomainRule* after,
                Forecasts& out) {
  if (after == nullptr)
    return out.add(GovernanceOutcome::restart, "a domain has no rule any more", 0);
  const auto added = governance::live_change(before, *after);
  if (!added) {
    const auto& details = added.error().details();
    const auto why =
        details.field == "topic_rule"
            ? fmt::format("{} is not there", details.expected)
            : fmt::format("{}: {} became {}", details.field, details.expected, details.found);
    return out.add(GovernanceOutcome::restart, why, details.line);
  }
  if (!added->domain.empty()) {
    out.raises = true;
    const auto& kind = added->domain.front();
    const auto why = fmt::format("{}: {} became {}", kind.element, kind.former, kind.next);
    out.embedded.add(GovernanceOutcome::two_phases, why, kind.line);
    out.cyclonedds.add(GovernanceOutcome::restart, why, kind.line);
  }
  if (!added->raised.empty()) {
    out.raises = true;
    const auto& raised = *added->raised.front();
    const auto why = fmt::format("more protection for \"{}\"", raised.topic_expression);
    out.embedded.add(GovernanceOutcome::two_phases, why, raised.line);
    out.cyclonedds.add(GovernanceOutcome::live_unless_in_use, why, raised.line);
  }
  if (added->rules.empty()) return;
  const auto& first = *added->rules.front();
  const auto why = fmt::format("a further rule for \"{}\"", first.topic_expression);
  const auto unless_in_use =
      added->fit_in_use ? GovernanceOutcome::two_phases : GovernanceOutcome::live_unless_in_use;
  if (added->are_last || added->are_alike) return out.add(GovernanceOutcome::live, why, first.line);
  out.embedded.add(unless_in_use, why, first.line);
  out.cyclonedds.add(GovernanceOutcome::live_unless_in_use, why, first.line);
}

// Predicts for a signed document without a revision. A document that is not signed yet gets the
// next revision.
void add_missing_revision(const governance::Governance& before, const DiffSides& sides,
                          Forecasts& out) {
  if (!sides.after.is_signed || sides.after.text == sides.before.text) return;
  if (before.revision > 0)
    return out.add(
        GovernanceOutcome::no_revision,
        fmt::format("the old document has revision {}, the new one none", before.revision), 0);
  if (out.raises)
    return out.add(GovernanceOutcome::no_revision, "more protection needs a revision", 0);
  if (out.embedded.outcome == GovernanceOutcome::two_phases)
    out.embedded.add(GovernanceOutcome::live_unless_in_use, out.embedded.reason, out.embedded.line);
}

// A document with the same revision as the former one must have the same content.
void add_revision(const governance::Governance& before, const governance::Governance& after,
                  const DiffSides& sides, Forecasts& out) {
  if (after.revision == 0) return add_missing_revision(before, sides, out);
  const bool is_same = out.worse().outcome == GovernanceOutcome::same;
  if (after.revision > before.revision || (after.revision == before.revision && is_same)) return;
  out.add(GovernanceOutcome::rolled_back,
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
  if (!kinds)
    out.add(GovernanceOutcome::restart, "there are too many expressions of tags to compare", 0);
  for (governance::NameKinds::Kind kind = 0; kinds && kind < kinds->size(); ++kind)
    tags.insert(kinds->example(kind));
  for (DomainId domain = 0; domain <= governance::kMaxGovernedDomainId; ++domain)
    for (const auto& tag : tags)
      if (const auto* rule = before.find(domain, tag))
        add_domain(*rule, after.find(domain, tag), out);
  out.is_phased = out.embedded.outcome == GovernanceOutcome::two_phases;
  add_revision(before, after, sides, out);
  return out;
}

std::string outcome_text(GovernanceOutcome live, bool is_ready) {
  std::string out(words_of(kGovernanceWords, live).text);
  if (live == GovernanceOutcome::two_phases && !is_ready)
    out += ", once it is signed: ddssec governance sign writes the revision that it needs";
  return out;
}

}  // namespace

GovernanceForecast forecast_of(const governance::Governance& before,
                               const governance::Governance& after, const DiffSides& sides,
                               bool is_same) {
  auto ours = forecast(before, after, sides);
  const auto &before_signer = sides.before.signer, &after_signer = sides.after.signer;
  if (!before_signer.empty() && !after_signer.empty() && before_signer != after_signer)
    ours.add(GovernanceOutcome::live_if_signer_accepted, "another CA signed the new document", 0);
  const auto& worse = ours.worse();
  const auto stock = is_same && worse.outcome == GovernanceOutcome::same
                         ? GovernanceOutcome::same
                         : GovernanceOutcome::restart;
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
        what.reason.empty() ? std::string() : fmt::format("({})", escaped(what.reason));
    out.text += wrapped(heading, {std::move(host), outcome_text(what.outcome, is_ready), reason});
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
