// Checks what a grant's deny_rules, and its rules for other domains, mean to stock products, topic
// by topic.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "governance/decision.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The input of the checks in this file.
struct DenialScene {
  const LoadedFolder& folder;
  const Settings& settings;
  Diagnosis& out;

  const fs::path& file() const { return folder.paths.permissions; }
};

// One name for each way in which the grant's expressions can match.
std::vector<std::string> sample_topics(const Grant& grant) {
  std::vector<RankedExpression> expressions;
  const auto add = [&](const std::vector<Criteria>& list) {
    for (const auto& criteria : list)
      for (const auto& text : criteria.topics)
        expressions.push_back({text.text, static_cast<std::uint32_t>(expressions.size()), 0});
  };
  for (const auto& rule : grant.rules) {
    add(rule.publish);
    add(rule.subscribe);
  }
  std::vector<std::string> out;
  if (const auto atoms = name_atoms(expressions))
    for (const auto& atom : *atoms) out.push_back(atom.witness);
  return out;
}

constexpr std::string_view kHintOfPartitions =
    "name the partitions that are allowed in an allow_rule, and leave the deny_rule out";

void diagnose_one_way(const DenialScene& scene, const Grant& grant) {
  const auto is_deny = [](const governance::GrantRule& rule) { return !rule.allow; };
  const auto outcomes = measured(Variant::grant_deny_one_way, scene.settings.lineup);
  if (std::ranges::none_of(grant.rules, is_deny) || outcomes.all_ok())
    return scene.out.pass(Rule::DOC053);
  const CompiledGrant compiled(scene.folder.permissions.model, grant, scene.settings.domain);
  for (const auto& topic : sample_topics(grant)) {
    const bool publish = compiled.judge_topic(Action::publish, topic).allowed;
    const bool subscribe = compiled.judge_topic(Action::subscribe, topic).allowed;
    const auto* rule = first_rule_naming(grant, scene.settings.domain, topic);
    if ((!publish && !subscribe) || rule == nullptr || rule->allow) continue;
    const auto product = name(Product::cyclonedds, scene.settings.lineup);
    return scene.out.report(
        outcomes,
        {.rule = Rule::DOC053,
         .message =
             publish && subscribe
                 ? fmt::format("grant \"{}\" denies topic \"{}\" in some partitions first, and "
                               "allows it in others: {} refuses the whole topic",
                               grant.name, topic, product)
                 : fmt::format("grant \"{}\" allows {} topic \"{}\" and denies the other "
                               "direction first: {} refuses the whole topic",
                               grant.name, publish ? "publishing" : "subscribing to", topic,
                               product),
         .document = scene.file(),
         .line = rule->line,
         .hint = std::string(publish && subscribe ? kHintOfPartitions : "")});
  }
  scene.out.pass(Rule::DOC053);
}

bool denies_partitions(const governance::GrantRule& rule) {
  const auto has_partitions = [](const Criteria& criteria) {
    return criteria.partitions.has_value();
  };
  return !rule.allow && (std::ranges::any_of(rule.publish, has_partitions) ||
                         std::ranges::any_of(rule.subscribe, has_partitions));
}

// Measured with Fast DDS 2.9.1: it denies in all partitions.
void diagnose_denied_partitions(const DenialScene& scene, const Grant& grant) {
  if (std::ranges::none_of(grant.rules, denies_partitions)) return;
  const auto domain = scene.settings.domain;
  const CompiledGrant compiled(scene.folder.permissions.model, grant, domain);
  for (const auto& topic : sample_topics(grant))
    for (const auto action : {Action::publish, Action::subscribe}) {
      const auto decision = judge_as(Product::fastdds, compiled, domain, action, {.topic = topic});
      const bool is_for_partitions = decision.criteria != nullptr && decision.criteria->partitions;
      if (!is_for_partitions || decision.rule->allow) continue;
      if (!compiled.judge_topic(action, topic).allowed) continue;
      return scene.out.report(
          {.fastdds = Outcome::late},
          {.rule = Rule::DOC053,
           .message = fmt::format("grant \"{}\" denies to {} topic \"{}\" in some partitions and "
                                  "allows it in others: {} denies it in all of them",
                                  grant.name, to_string(action), topic,
                                  name(Product::fastdds, scene.settings.lineup)),
           .document = scene.file(),
           .line = decision.rule->line,
           .hint = std::string(kHintOfPartitions)});
    }
}

// Returns a deny_rule for this domain that stock products read as a rule for another domain.
const governance::GrantRule* denial_elsewhere(const Grant& grant, DomainId domain) {
  const auto found = std::ranges::find_if(grant.rules, [&](const governance::GrantRule& rule) {
    return !rule.allow && rule.domains.contains(domain) && !rule.domains.contains_for_stock(domain);
  });
  return found == grant.rules.end() ? nullptr : &*found;
}

// Reports rights that a denial with an open range removes and that stock products still allow.
void diagnose_open_denials(const DenialScene& scene, const Grant& grant) {
  const auto domain = scene.settings.domain;
  const auto* rule = denial_elsewhere(grant, domain);
  if (rule == nullptr) return;
  const CompiledGrant compiled(scene.folder.permissions.model, grant, domain);
  for (const auto& topic : sample_topics(grant))
    for (const auto action : {Action::publish, Action::subscribe}) {
      if (compiled.judge_topic(action, topic).allowed) continue;
      const auto outcome = [&](Product product) {
        return judge_as(product, compiled, domain, action, {.topic = topic}).allowed
                   ? Outcome::unsafe
                   : Outcome::ok;
      };
      const Outcomes outcomes{.cyclonedds = outcome(Product::cyclonedds),
                              .fastdds = outcome(Product::fastdds)};
      if (outcomes.all_ok()) continue;
      return scene.out.report(
          outcomes,
          {.rule = Rule::DOC037,
           .message = fmt::format(
               "the deny_rule at line {} does not hold in domain {} with Cyclone DDS and Fast DDS, "
               "which read an <id_range> without <max> as one domain: to {} topic \"{}\" is "
               "allowed",
               rule->line, domain, to_string(action), topic),
           .document = scene.file(),
           .line = rule->line,
           .hint = "write both <min> and <max>, and sign the permissions again",
           .severity = Severity::error},
          "permissions");
    }
}

bool is_controlled(const DomainRule* domain, Action action, std::string_view topic) {
  const auto* const rule =
      domain != nullptr ? topic_rule_as(Product::fastdds, *domain, topic) : nullptr;
  return rule != nullptr && (action == Action::publish ? rule->enable_write_access_control
                                                       : rule->enable_read_access_control);
}

// Reports topics that the grant allows, but for which Fast DDS makes no endpoint, because it
// ignores the domains of a rule there.
void diagnose_rules_of_other_domains(const DenialScene& scene, const Grant& grant) {
  scene.out.pass(Rule::DOC109);
  const auto domain = scene.settings.domain;
  const auto is_for_others = [&](const governance::GrantRule& rule) {
    return !rule.domains.contains_for_stock(domain);
  };
  if (!scene.folder.governance.model || std::ranges::none_of(grant.rules, is_for_others)) return;
  const auto* const governance =
      domain_rule_as(Product::fastdds, *scene.folder.governance.model, domain);
  const CompiledGrant compiled(scene.folder.permissions.model, grant, domain);
  for (const auto& topic : sample_topics(grant))
    for (const auto action : {Action::publish, Action::subscribe}) {
      if (!is_controlled(governance, action, topic)) continue;
      const auto judged = [&](const auto& judge) {
        return judge(Product::fastdds, compiled, domain, action, Request{.topic = topic});
      };
      const auto local = judged(judge_local_as);
      if (local.allowed || local.rule == nullptr || !judged(judge_as).allowed) continue;
      return scene.out.report(
          {.fastdds = Outcome::late},
          {.rule = Rule::DOC109,
           .message = fmt::format("grant \"{}\" allows to {} topic \"{}\" in domain {}, and {} "
                                  "refuses it by the rule at line {}, which is for other domains",
                                  grant.name, to_string(action), topic, domain,
                                  name(Product::fastdds, scene.settings.lineup), local.rule->line),
           .document = scene.file(),
           .line = local.rule->line});
    }
}

}  // namespace

void diagnose_denials(const LoadedFolder& folder, const Settings& settings, const Grant& grant,
                      Diagnosis& out) {
  const DenialScene scene{folder, settings, out};
  diagnose_denied_partitions(scene, grant);
  diagnose_one_way(scene, grant);
  diagnose_open_denials(scene, grant);
  diagnose_rules_of_other_domains(scene, grant);
}

}  // namespace ddssec::governance::doctor
