// governance show, permissions show: display the effect of a document.
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/commands/groups.hpp"
#include "cli/diff/diff_inputs.hpp"
#include "cli/documents/documents.hpp"
#include "governance/compare/protection_properties.hpp"
#include "governance/decision.hpp"
#include "governance/grant.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using governance::DomainRule;
using governance::Governance;
using governance::Grant;
using governance::Property;
using governance::TopicRule;

Json range_list(const governance::DomainSet& domains) { return domains_json(domains.ranges); }

Json to_json(const TopicRule& rule) {
  return {{"expression", rule.topic_expression},
          {"line", rule.line},
          {"data", to_string(rule.data_protection_kind)},
          {"metadata", to_string(rule.metadata_protection_kind)},
          {"discovery", rule.enable_discovery_protection},
          {"liveliness", rule.enable_liveliness_protection},
          {"read_access_control", rule.enable_read_access_control},
          {"write_access_control", rule.enable_write_access_control}};
}

Json to_json(const DomainRule& rule) {
  Json out = {{"domains", range_list(rule.domains)},
              {"line", rule.line},
              {"allow_unauthenticated", rule.allow_unauthenticated_participants},
              {"join_access_control", rule.enable_join_access_control},
              {"discovery", to_string(rule.discovery_protection_kind)},
              {"liveliness", to_string(rule.liveliness_protection_kind)},
              {"rtps", to_string(rule.rtps_protection_kind)}};
  if (is_protected(rule.rtps_psk_protection_kind))
    out["pre_shared_key"] = to_string(rule.rtps_psk_protection_kind);
  if (rule.enable_key_revision) out["key_revision"] = true;
  return out;
}

/// Of DDS-Security 1.2: nothing where there is none, as everywhere but in domains of embedded
/// participants.
std::string newer_elements(const DomainRule& rule) {
  std::string out;
  if (is_protected(rule.rtps_psk_protection_kind))
    out += fmt::format("  pre-shared key {}", to_string(rule.rtps_psk_protection_kind));
  if (rule.enable_key_revision) out += "  keys are revised";
  return out;
}

std::string_view yes(bool value) { return value ? "yes" : "no"; }

std::string domain_text(const DomainRule& rule, std::size_t number, const fs::path& file) {
  return fmt::format(
      "domain rule {}: {} ({}:{})\n"
      "  discovery {}  liveliness {}  rtps {}{}\n"
      "  strangers {}, permissions needed to join: {}\n",
      number, shown(rule.domains.ranges), file.string(), rule.line,
      to_string(rule.discovery_protection_kind), to_string(rule.liveliness_protection_kind),
      to_string(rule.rtps_protection_kind), newer_elements(rule),
      rule.allow_unauthenticated_participants ? "allowed" : "refused",
      yes(rule.enable_join_access_control));
}

std::string topic_row(const TopicRule& rule, std::size_t number) {
  return fmt::format(
      "  {:>4}  {:<40} data {:<8} metadata {:<8} read {} write {} discovery {} "
      "(line {})\n",
      number, shown(rule.topic_expression), to_string(rule.data_protection_kind),
      to_string(rule.metadata_protection_kind),
      rule.enable_read_access_control ? "by permission" : "free",
      rule.enable_write_access_control ? "by permission" : "free",
      rule.enable_discovery_protection ? "protected" : "open", rule.line);
}

Report whole(const Governance& document, const fs::path& file) {
  Report report;
  report.result = {{"file", file.string()}, {"domain_rules", Json::array()}};
  if (document.revision != 0) {
    report.text = fmt::format("revision {}\n", document.revision);
    report.result["revision"] = document.revision;
  }
  for (std::size_t i = 0; i < document.domain_rules.size(); ++i) {
    const auto& rule = document.domain_rules[i];
    auto row = to_json(rule);
    row["topic_rules"] = Json::array();
    report.text += domain_text(rule, i + 1, file);
    for (std::size_t j = 0; j < rule.topic_rules.size(); ++j) {
      report.text += topic_row(rule.topic_rules[j], j + 1);
      row["topic_rules"].push_back(to_json(rule.topic_rules[j]));
    }
    report.result["domain_rules"].push_back(std::move(row));
  }
  return report;
}

/// The rules that decide for one topic of one domain.
struct Deciding {
  const DomainRule& domain;
  const TopicRule& topic;
  std::size_t domain_number, topic_number;
};

bool has(const governance::Properties& properties, Property property) {
  return properties.test(static_cast<std::size_t>(property));
}

std::string achieved(bool secret, bool authentic) {
  if (!secret && !authentic) return "nothing";
  return fmt::format("{}{}{}", secret ? "confidential" : "", secret && authentic ? ", " : "",
                     authentic ? "authentic" : "");
}

std::string sentence(const governance::Properties& p) {
  using enum Property;
  return fmt::format(
      "  against outsiders: {}   against insiders without the right: {}\n"
      "  against relays: {}\n",
      achieved(has(p, outsider_payload_secrecy), has(p, outsider_payload_integrity)),
      achieved(has(p, insider_payload_secrecy), has(p, insider_payload_integrity)),
      achieved(has(p, relay_payload_secrecy), has(p, relay_payload_integrity)));
}

/// The requirement for reading or writing a topic.
std::string_view asked_of(bool access_control) {
  return access_control ? "by permission" : "free: every participant of the domain";
}

std::string_view effect(bool flag, ProtectionKind kind) {
  return flag && is_protected(kind) ? "protected" : "open";
}

std::string to_text(const Deciding& by, const fs::path& file, const std::string& topic,
                    DomainId domain) {
  const auto& [rule, row, rule_number, row_number] = by;
  return fmt::format(
             "topic {}, domain {}           rule {} {} ({}:{})\n"
             "  payload    {:<12} metadata   {:<12} rtps  {} (domain rule {}, line {})\n"
             "  discovery  {:<12} liveliness {}\n"
             "  access     read {}, write {}\n",
             shown(topic), domain, row_number, '"' + shown(row.topic_expression) + '"',
             file.string(), row.line, to_string(row.data_protection_kind),
             to_string(row.metadata_protection_kind), to_string(rule.rtps_protection_kind),
             rule_number, rule.line,
             effect(row.enable_discovery_protection, rule.discovery_protection_kind),
             effect(row.enable_liveliness_protection, rule.liveliness_protection_kind),
             asked_of(row.enable_read_access_control), asked_of(row.enable_write_access_control)) +
         sentence(properties(rule, row));
}

template <class T>
std::size_t number_in(const std::vector<T>& all, const T& one) {
  return static_cast<std::size_t>(&one - all.data()) + 1;
}

// Without --domain: the first domain that is covered.
DomainId domain_for(const Governance& document, std::optional<DomainId> wanted) {
  return wanted.value_or(document.domain_rules.front().domains.ranges.front().first);
}

Result<Report> one_topic(const Governance& document, const fs::path& file, const std::string& topic,
                         DomainId domain) {
  const auto* rule = document.find(domain);
  if (rule == nullptr)
    return fail(
        Code::domain_not_covered,
        {.document = file, .field = "<domains>", .expected = "domain " + std::to_string(domain)});
  const auto row = std::ranges::find_if(rule->topic_rules, [&](const TopicRule& r) {
    return governance::Pattern(r.topic_expression).matches(topic);
  });
  if (row == rule->topic_rules.end())
    return fail(Code::topic_not_covered, {.document = file, .line = rule->line, .found = topic});
  const Deciding by{*rule, *row, number_in(document.domain_rules, *rule),
                    number_in(rule->topic_rules, *row)};
  Report report;
  report.text = to_text(by, file, topic, domain);
  report.result = {{"file", file.string()}, {"topic", topic}, {"domain", domain}};
  report.result["domain_rule"] = to_json(*rule);
  report.result["domain_rule"]["number"] = by.domain_number;
  report.result["topic_rule"] = to_json(*row);
  report.result["topic_rule"]["number"] = by.topic_number;
  report.result["properties"] = Json::array();
  for (const auto property : governance::listed(properties(*rule, *row)))
    report.result["properties"].push_back(to_string(property));
  return report;
}

Result<Report> governance_show(const Arguments& arguments, const Context&) {
  const auto file = document_path<GovernanceKind>(arguments.text("FILE"));
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, domain_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<GovernanceKind>(file));
  if (arguments.has("--topic"))
    return one_topic(document, file, arguments.text("--topic"), domain_for(document, wanted));
  if (wanted && document.find(*wanted) == nullptr)
    return fail(Code::domain_not_covered,
                {.document = file, .expected = "domain " + std::to_string(*wanted)});
  if (!wanted) return whole(document, file);
  Governance part{.revision = document.revision};
  part.domain_rules.push_back(*document.find(*wanted));
  return whole(part, file);
}

Json texts_json(const std::vector<governance::Text>& texts) {
  Json out = Json::array();
  for (const auto& text : texts) out.push_back(text.text);
  return out;
}

Json to_json(const std::vector<governance::Criteria>& list) {
  Json out = Json::array();
  for (const auto& criteria : list) {
    Json row = {
        {"line", criteria.line},
        {"topics", texts_json(criteria.topics)},
        {"partitions", criteria.partitions ? texts_json(*criteria.partitions) : Json::array()}};
    if (criteria.data_tags) {
      row["data_tags"] = Json::array();
      for (const auto& tag : *criteria.data_tags)
        row["data_tags"].push_back({{"name", tag.name}, {"value", tag.value}});
    }
    out.push_back(std::move(row));
  }
  return out;
}

// Of DDS-Security 1.2: only where there are some.
void add_domain_tags(Json& out, const governance::DomainSet& domains) {
  if (!domains.tags.empty()) out["domain_tags"] = texts_json(domains.tags);
  if (!domains.tag_expressions.empty())
    out["domain_tag_expressions"] = texts_json(domains.tag_expressions);
}

Json to_json(const governance::Rule& rule) {
  Json out = {{"allow", rule.allow},
              {"line", rule.line},
              {"domains", range_list(rule.domains)},
              {"publish", to_json(rule.publish)},
              {"subscribe", to_json(rule.subscribe)},
              {"relay", to_json(rule.relay)}};
  add_domain_tags(out, rule.domains);
  return out;
}

std::string joined_texts(const std::vector<governance::Text>& texts) {
  std::string out;
  // Whole, unlike in a comparison: two names may differ in their last letter.
  for (const auto& text : texts)
    out += (out.empty() ? "" : ", ") + (text.text.empty() ? "(empty name)" : printable(text.text));
  return out;
}

std::string data_tags(const governance::Criteria& criteria) {
  std::string out;
  if (!criteria.data_tags) return out;
  for (const auto& tag : *criteria.data_tags)
    out += fmt::format("{}{}={}", out.empty() ? "  with data tags " : ", ", shown(tag.name),
                       shown(tag.value));
  return out.empty() ? "  with no data tags" : out;
}

void add_rows(std::string& out, std::string_view action,
              const std::vector<governance::Criteria>& list) {
  for (const auto& criteria : list)
    out += fmt::format(
        "      {:<10} {}{}{}  (line {})\n", action, joined_texts(criteria.topics),
        criteria.partitions ? "  in partitions " + joined_texts(*criteria.partitions) : "",
        data_tags(criteria), criteria.line);
}

std::string to_text(const Grant& grant, WallTime now) {
  auto out = fmt::format("{}  {} .. {}{}  (line {})\n", shown(grant.subject_name),
                         to_string(grant.validity.not_before), to_string(grant.validity.not_after),
                         grant.validity.contains(now) ? "" : "  NOT VALID NOW", grant.line);
  for (std::size_t i = 0; i < grant.rules.size(); ++i) {
    const auto& rule = grant.rules[i];
    out += fmt::format("  {:>2}  {:<5} {}  (line {})\n", i + 1, rule.allow ? "allow" : "deny",
                       shown(rule.domains.ranges), rule.line);
    add_rows(out, "publish", rule.publish);
    add_rows(out, "subscribe", rule.subscribe);
    add_rows(out, "relay", rule.relay);
  }
  return out + fmt::format("      all else: {}\n", grant.default_allow ? "ALLOWED" : "denied");
}

Json to_json(const Grant& grant, WallTime now) {
  Json out = {{"name", grant.name},
              {"subject", grant.subject_name},
              {"line", grant.line},
              {"not_before", to_string(grant.validity.not_before)},
              {"not_after", to_string(grant.validity.not_after)},
              {"valid_now", grant.validity.contains(now)},
              {"default", grant.default_allow ? "ALLOW" : "DENY"},
              {"rules", Json::array()}};
  for (const auto& rule : grant.rules) out["rules"].push_back(to_json(rule));
  return out;
}

Result<Report> permissions_show(const Arguments& arguments, const Context& context) {
  const auto file = document_path<PermissionsKind>(arguments.text("FILE"));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<PermissionsKind>(file));
  std::optional<pki::SubjectName> subject;
  if (arguments.has("--subject")) {
    DDSSEC_ASSIGN_OR_RETURN(subject, pki::SubjectName::parse(arguments.text("--subject")));
  }
  Report report;
  report.result = {{"file", file.string()}, {"grants", Json::array()}};
  for (const auto& grant : document.grants) {
    if (subject && !is_for(grant, *subject)) continue;
    report.text += to_text(grant, context.clock.now());
    report.result["grants"].push_back(to_json(grant, context.clock.now()));
  }
  if (subject && report.result["grants"].empty())
    return fail(Code::no_grant_for_subject,
                {.document = file, .expected = arguments.text("--subject")});
  return report;
}

const Positional kDocument{
    "FILE", "the document, XML or signed, or a participant's folder (no signature is verified)"};

}  // namespace

std::vector<Command> show_commands() {
  return {{.group = "governance",
           .name = "show",
           .summary = "Shows what a governance document gives a topic, and which rule decides.",
           .positionals = {kDocument},
           .options = {{"--topic", "NAME", "for this topic only"},
                       {"--domain", "N", "for this domain only"}},
           .examples = {"ddssec governance show governance.p7s --topic rt/chatter --domain 0"},
           .run = governance_show},
          {.group = "permissions",
           .name = "show",
           .summary = "Shows who may publish and subscribe what, and until when.",
           .positionals = {kDocument},
           .options = {{"--subject", "DN", "for this subject only"}},
           .examples = {"ddssec permissions show permissions.p7s --subject CN=talker"},
           .run = permissions_show}};
}

}  // namespace ddssec::cli
