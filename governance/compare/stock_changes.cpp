#include "governance/compare/stock_changes.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "governance/domain_cuts.hpp"
#include "governance/lint_findings.hpp"

namespace ddssec::governance {
namespace {

constexpr ChangeClass kWorse[] = {ChangeClass::weaker, ChangeClass::wider, ChangeClass::mixed,
                                  ChangeClass::unknown};

bool is_worse(ChangeClass change) { return std::ranges::find(kWorse, change) != std::end(kWorse); }

bool loses(ChangeClass change) {
  return change == ChangeClass::narrower || change == ChangeClass::mixed ||
         change == ChangeClass::unknown;
}

bool covers(const DomainScope& outer, const DomainScope& inner) {
  return std::ranges::all_of(inner.domains, [&](const DomainRange& range) {
    return std::ranges::any_of(outer.domains, [&](const DomainRange& one) {
      return one.first <= range.first && range.last <= one.last;
    });
  });
}

std::string domains_of(const DomainScope& scope) {
  return scope.domains.empty() ? std::string() : " in domain " + to_text(scope.domains);
}

void put(Interpretations& interpretations, Interpretation interpretation) {
  if (interpretations.all.size() < kMaxInterpretations)
    interpretations.all.push_back(std::move(interpretation));
  else
    interpretations.is_complete = false;
}

// True if both are about the same element, and `ours` is not less serious and covers at least the
// same domains.
bool is_same(const GovernanceChange& ours, const GovernanceChange& theirs) {
  return ours.element.element == theirs.element.element &&
         ours.element.old_value == theirs.element.old_value &&
         ours.element.new_value == theirs.element.new_value &&
         (ours.element.change == theirs.element.change || is_worse(ours.element.change)) &&
         covers(ours.scope, theirs.scope);
}

std::string to_sentence(const GovernanceChange& change) {
  const auto& [element, old_value, new_value, kind, interop] = change.element;
  return fmt::format(
      "{} {} -> {}{}{}: {}", element, old_value, new_value, domains_of(change.scope),
      change.is_about_topics ? ", for topics such as " + in_quotes(change.witness) : std::string(),
      to_string(kind));
}

bool is_same(const PermissionChange& ours, const PermissionChange& theirs) {
  return ours.subject == theirs.subject && ours.element == theirs.element &&
         ours.operation == theirs.operation && ours.old_value == theirs.old_value &&
         ours.new_value == theirs.new_value && ours.change == theirs.change &&
         ours.witness == theirs.witness && ours.topics.words.size() == theirs.topics.words.size() &&
         ours.entities.every == theirs.entities.every &&
         ours.entities.example_partitions == theirs.entities.example_partitions &&
         covers(ours.scope, theirs.scope);
}

std::string to_sentence(const PermissionChange& change) {
  auto out =
      fmt::format("{}{}{}", change.element, change.operation.empty() ? "" : " ", change.operation);
  if (change.is_about_topics) out += " of topics such as " + in_quotes(change.witness);
  out += fmt::format(" {} -> {}{}", change.old_value, change.new_value, domains_of(change.scope));
  for (const auto& partition : change.entities.example_partitions)
    out += ", partition " + in_quotes(partition);
  return fmt::format("{} for {}: {}", out, in_quotes(change.subject), to_string(change.change));
}

template <class Change>
bool is_among(const std::vector<Change>& all, const Change& one) {
  return std::ranges::any_of(all, [&](const Change& each) { return is_same(each, one); });
}

constexpr std::string_view kFastDdsOwnEndpoints =
    "Fast DDS, which applies rules for every domain to its own writers and readers";

// True if the decisions about peers show the change too, although for fewer topics or domains: the
// verdict then reports it.
bool is_found_elsewhere(const std::vector<StockPermissionsDiff>& stock, const PermissionsDiff& ours,
                        const PermissionChange& change) {
  const auto is_in = [&](const PermissionsDiff& diff) {
    return std::ranges::any_of(diff.changes, [&](const PermissionChange& one) {
      return one.subject == change.subject && one.element == change.element &&
             one.operation == change.operation && one.change == change.change;
    });
  };
  return is_in(ours) || std::ranges::any_of(stock, [&](const StockPermissionsDiff& one) {
           return one.product == StockProduct::fastdds && !one.is_of_own_endpoints &&
                  is_in(one.diff);
         });
}

// The changes that products have and ddssec does not, each once, with the products that have it.
class StockChanges {
 public:
  void add(std::string_view product, Interpretation interpretation) {
    const auto known = std::ranges::find_if(
        all_, [&](const auto& one) { return one.second.sentence == interpretation.sentence; });
    if (known != all_.end())
      known->first += fmt::format(" and {}", product);
    else
      all_.emplace_back(product, std::move(interpretation));
  }
  void put_into(Interpretations& interpretations) && {
    for (auto& [products, interpretation] : all_) {
      interpretation.sentence = fmt::format("with {}: {}", products, interpretation.sentence);
      put(interpretations, std::move(interpretation));
    }
  }

 private:
  std::vector<std::pair<std::string, Interpretation>> all_;
};

}  // namespace

void add_stock_changes(const std::vector<StockGovernanceDiff>& stock, GovernanceDiff& ours) {
  StockChanges found;
  const bool is_known = ours.verdict != ChangeClass::unknown;
  for (const auto& [product, diff] : stock) {
    for (const auto& change : diff.changes)
      if (!is_among(ours.changes, change))
        found.add(to_string(product), {.is_new = true,
                                       .expression = {},
                                       .sentence = to_sentence(change),
                                       .line = change.new_line(),
                                       .widens = is_worse(change.element.change)});
    if (diff.verdict == ChangeClass::unknown && is_known)
      found.add(to_string(product), {.is_new = true,
                                     .expression = {},
                                     .sentence = "what changes is not known",
                                     .widens = true});
    ours.parts_participants |= diff.parts_participants;
    ours.flag_day_domains.insert(ours.flag_day_domains.end(), diff.flag_day_domains.begin(),
                                 diff.flag_day_domains.end());
  }
  std::move(found).put_into(ours.interpretations);
  ours.flag_day_domains = joined(std::move(ours.flag_day_domains));
}

void add_stock_changes(const std::vector<StockPermissionsDiff>& stock, PermissionsDiff& ours) {
  StockChanges found;
  const bool is_exact = ours.verdict != ChangeClass::unknown;
  for (const auto& [product, diff, is_of_own_endpoints] : stock) {
    if (diff.verdict == ChangeClass::unknown && is_exact)
      found.add(to_string(product), {.is_new = true,
                                     .expression = {},
                                     .sentence = "what changes is not known",
                                     .widens = true});
    for (const auto& change : diff.changes) {
      const bool is_known = is_of_own_endpoints ? is_found_elsewhere(stock, ours, change)
                                                : is_among(ours.changes, change);
      if (change.change == ChangeClass::neutral || is_known) continue;
      found.add(is_of_own_endpoints ? kFastDdsOwnEndpoints : to_string(product),
                {.is_new = true,
                 .expression = {},
                 .sentence = to_sentence(change),
                 .line = change.new_line,
                 .widens = is_worse(change.change),
                 .narrows = loses(change.change)});
    }
  }
  std::move(found).put_into(ours.interpretations);
}

}  // namespace ddssec::governance
