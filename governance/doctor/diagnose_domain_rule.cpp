// Checks the governance document's rule for the participant's domain.
#include <fmt/format.h>

#include "governance/doctor/checks.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance::doctor {
namespace {

void report_uncovered(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  std::vector<DomainRange> all;
  for (const auto& rule : folder.governance.model->domain_rules)
    all.insert(all.end(), rule.domains.ranges.begin(), rule.domains.ranges.end());
  const auto& rules = folder.governance.model->domain_rules;
  auto outcomes = measured(Variant::governance_other_domain, settings.lineup);
  outcomes.ddssec = Outcome::fail;
  const auto mismatch = mismatch_texts(folder, settings.now);
  out.report(outcomes,
             {.rule = Rule::DOC050,
              .message = fmt::format("no <domain_rule> of {} covers domain {}; they cover {}{}",
                                     folder.paths.governance.filename().string(), settings.domain,
                                     to_text(merged(std::move(all))), mismatch.words),
              .document = folder.paths.governance,
              .line = rules.empty() ? 0 : rules.front().domains.line,
              .hint = folder.paths.layout == pki::FolderLayout::sros2
                          ? fmt::format("start the node in a domain that the keystore is for "
                                        "(ROS_DOMAIN_ID), or make a keystore for this one: ddssec "
                                        "keystore create KEYSTORE --domain {}",
                                        settings.domain)
                          : mismatch.hint});
}

// Cyclone DDS and Fast DDS read a range without <max> as one domain. Another rule, or none, may
// then be the first one for this domain.
void diagnose_open_ranges(const LoadedFolder& folder, const DomainRule& rule,
                          const Settings& settings, Diagnosis& out) {
  const auto* stock = folder.governance.model->find_for_stock(settings.domain);
  if (stock == &rule) return out.pass(Rule::DOC050);
  const auto outcomes = stock == nullptr
                            ? measured(Variant::governance_other_domain, settings.lineup)
                            : Outcomes{.cyclonedds = Outcome::unsafe, .fastdds = Outcome::unsafe};
  const auto theirs = stock == nullptr ? std::string("no <domain_rule>")
                                       : fmt::format("the <domain_rule> at line {}", stock->line);
  out.report(outcomes,
             {.rule = Rule::DOC050,
              .message = fmt::format("for domain {} Cyclone DDS and Fast DDS apply {}, not the one "
                                     "at line {}: they read an <id_range> without <max> as one "
                                     "domain",
                                     settings.domain, theirs, rule.line),
              .document = folder.paths.governance,
              .line = rule.domains.line});
}

void diagnose_topic_rules(const LoadedFolder& folder, const DomainRule& rule, Diagnosis& out) {
  std::vector<std::string_view> expressions;
  for (const auto& topic : rule.topic_rules) expressions.emplace_back(topic.topic_expression);
  constexpr std::string_view kEvery = "*";
  const auto answer = contained({&kEvery, 1}, expressions);
  if (answer.kind != SetAnswer::Kind::no) return out.pass(Rule::DOC054);
  out.report({}, {.rule = Rule::DOC054,
                  .message = fmt::format("no <topic_rule> matches every topic: one named \"{}\" "
                                         "cannot be created",
                                         answer.witness),
                  .document = folder.paths.governance,
                  .line = rule.line});
}

// Fast DDS 2.9.1 reads allow_unauthenticated_participants and ignores it. Later versions refuse it
// together with protection of all messages.
void diagnose_unauthenticated(const LoadedFolder& folder, const DomainRule& rule,
                              const Lineup& lineup, Diagnosis& out) {
  if (!rule.allow_unauthenticated_participants) return;
  const auto who =
      measured(is_protected(rule.rtps_protection_kind) ? Variant::governance_unauthenticated
                                                       : Variant::governance_unauthenticated_open,
               lineup);
  const auto fastdds = name(Product::fastdds, lineup);
  out.report(who,
             {.rule = Rule::DOC055,
              .message = "<allow_unauthenticated_participants> is true: Cyclone DDS then talks "
                         "to every participant, also on topics with access control; " +
                         (who.fastdds == Outcome::ok
                              ? fastdds + " talks to authenticated participants only"
                              : fastdds + " refuses it together with <rtps_protection_kind> " +
                                    std::string(to_string(rule.rtps_protection_kind))),
              .document = folder.paths.governance,
              .line = rule.line,
              .products = {id(Product::cyclonedds, lineup), id(Product::fastdds, lineup)},
              .severity = who.all_ok() ? Severity::warning : Severity::error});
}

}  // namespace

const DomainRule* diagnosed_domain_rule(const LoadedFolder& folder, const Settings& settings,
                                        Diagnosis& out) {
  if (!folder.governance.model) return nullptr;
  const auto* rule = folder.governance.model->find(settings.domain);
  if (rule == nullptr) {
    report_uncovered(folder, settings, out);
    return nullptr;
  }
  diagnose_open_ranges(folder, *rule, settings, out);
  diagnose_topic_rules(folder, *rule, out);
  diagnose_unauthenticated(folder, *rule, settings.lineup, out);
  return rule;
}

}  // namespace ddssec::governance::doctor
