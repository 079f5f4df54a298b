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

constexpr Shown kKind{.def = "protection_kind"};

Json range_list(const governance::DomainSet& domains) { return domains_json(domains.ranges); }

struct TopicRuleFacts {
  static constexpr std::string_view kDef = "topic_rule";
  std::string expression;
  int line;
  std::string data, metadata;
  bool discovery, liveliness, read_access_control, write_access_control;

  static TopicRuleFacts of(const TopicRule& rule) {
    return {rule.topic_expression,
            rule.line,
            std::string(to_string(rule.data_protection_kind)),
            std::string(to_string(rule.metadata_protection_kind)),
            rule.enable_discovery_protection,
            rule.enable_liveliness_protection,
            rule.enable_read_access_control,
            rule.enable_write_access_control};
  }
  static constexpr auto fields() {
    using Self = TopicRuleFacts;
    return std::tuple(field<&Self::expression>(), field<&Self::line>(), field<&Self::data>(kKind),
                      field<&Self::metadata>(kKind), field<&Self::discovery>(),
                      field<&Self::liveliness>(), field<&Self::read_access_control>(),
                      field<&Self::write_access_control>());
  }
};

struct DomainRuleFacts {
  Json domains;
  int line;
  bool allow_unauthenticated, join_access_control;
  std::string discovery, liveliness, rtps;
  // Of DDS-Security 1.2: nothing where there is none, as everywhere but in domains of embedded
  // participants.
  std::optional<std::string> pre_shared_key = {};
  std::optional<bool> key_revision = {};
  std::string domain_words = {};

  static DomainRuleFacts of(const DomainRule& rule) {
    DomainRuleFacts out{.domains = range_list(rule.domains),
                        .line = rule.line,
                        .allow_unauthenticated = rule.allow_unauthenticated_participants,
                        .join_access_control = rule.enable_join_access_control,
                        .discovery = std::string(to_string(rule.discovery_protection_kind)),
                        .liveliness = std::string(to_string(rule.liveliness_protection_kind)),
                        .rtps = std::string(to_string(rule.rtps_protection_kind)),
                        .domain_words = shown(rule.domains.ranges)};
    if (is_protected(rule.rtps_psk_protection_kind))
      out.pre_shared_key = to_string(rule.rtps_psk_protection_kind);
    if (rule.enable_key_revision) out.key_revision = true;
    return out;
  }
  static constexpr auto fields() {
    using Self = DomainRuleFacts;
    return std::tuple(field<&Self::domains>({.def = "domain_ranges"}), field<&Self::line>(),
                      field<&Self::allow_unauthenticated>(), field<&Self::join_access_control>(),
                      field<&Self::discovery>(kKind), field<&Self::liveliness>(kKind),
                      field<&Self::rtps>(kKind),
                      field<&Self::pre_shared_key>(
                          {.note = "if there is one", .words = "SIGN|ENCRYPT", .absent = true}),
                      field<&Self::key_revision>({.note = "if keys are revised", .absent = true}));
  }
  std::string newer_elements() const {
    std::string out;
    if (pre_shared_key) out += fmt::format("  pre-shared key {}", *pre_shared_key);
    if (key_revision) out += "  keys are revised";
    return out;
  }
};

std::string_view yes(bool value) { return value ? "yes" : "no"; }

std::string topic_row(const TopicRuleFacts& rule, std::size_t number) {
  return fmt::format(
      "  {:>4}  {:<40} data {:<8} metadata {:<8} read {} write {} discovery {} "
      "(line {})\n",
      number, shown(rule.expression), rule.data, rule.metadata,
      rule.read_access_control ? "by permission" : "free",
      rule.write_access_control ? "by permission" : "free", rule.discovery ? "protected" : "open",
      rule.line);
}

struct ShownDomainRule {
  DomainRuleFacts rule;
  std::vector<TopicRuleFacts> topic_rules = {};

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&ShownDomainRule::rule),
                          std::tuple(field<&ShownDomainRule::topic_rules>()));
  }
  std::string text(std::size_t number, const fs::path& file) const {
    auto out = fmt::format(
        "domain rule {}: {} ({}:{})\n"
        "  discovery {}  liveliness {}  rtps {}{}\n"
        "  strangers {}, permissions needed to join: {}\n",
        number, rule.domain_words, file.string(), rule.line, rule.discovery, rule.liveliness,
        rule.rtps, rule.newer_elements(), rule.allow_unauthenticated ? "allowed" : "refused",
        yes(rule.join_access_control));
    for (std::size_t i = 0; i < topic_rules.size(); ++i) out += topic_row(topic_rules[i], i + 1);
    return out;
  }
};

struct ShownGovernance {
  fs::path file;
  std::vector<ShownDomainRule> domain_rules = {};
  std::optional<std::size_t> revision = {};

  static ShownGovernance of(const Governance& document, const fs::path& file) {
    ShownGovernance out{file};
    if (document.revision != 0) out.revision = document.revision;
    for (const auto& rule : document.domain_rules) {
      out.domain_rules.push_back({DomainRuleFacts::of(rule)});
      for (const auto& topic : rule.topic_rules)
        out.domain_rules.back().topic_rules.push_back(TopicRuleFacts::of(topic));
    }
    return out;
  }
  static constexpr auto fields() {
    using Self = ShownGovernance;
    return std::tuple(
        field<&Self::file>(), field<&Self::domain_rules>({.least = 1}),
        field<&Self::revision>({.note = "if it has one", .def = "revision", .absent = true}));
  }
  std::string text() const {
    auto out = revision ? fmt::format("revision {}\n", *revision) : "";
    for (std::size_t i = 0; i < domain_rules.size(); ++i) out += domain_rules[i].text(i + 1, file);
    return out;
  }
};

/// A rule and which of the document's it is.
template <class Facts>
struct Numbered {
  Facts rule;
  std::size_t number;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&Numbered::rule), std::tuple(field<&Numbered::number>()));
  }
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

std::string_view effect(bool flag, std::string_view kind) {
  return flag && kind != to_string(ProtectionKind::none) ? "protected" : "open";
}

/// The rules that decide for one topic of one domain.
struct ShownTopic {
  static constexpr std::string_view kWhen = "with --topic";
  fs::path file;
  std::string topic;
  DomainId domain;
  Numbered<DomainRuleFacts> domain_rule;
  Numbered<TopicRuleFacts> topic_rule;
  std::vector<std::string> properties;
  std::string achieves;  ///< the properties in words: complete lines

  static constexpr auto fields() {
    using Self = ShownTopic;
    return std::tuple(
        field<&Self::file>(), field<&Self::topic>(), field<&Self::domain>(),
        field<&Self::domain_rule>(
            {.note = "the same without `topic_rules`, and `number`", .same = true}),
        field<&Self::topic_rule>({.note = "the same, and `number`", .same = true}),
        field<&Self::properties>({.pattern = "^(outsider|insider|relay)\\.[a-z_]+$"}));
  }
  std::string text() const {
    const auto& [rule, rule_number] = domain_rule;
    const auto& [row, row_number] = topic_rule;
    return fmt::format(
               "topic {}, domain {}           rule {} {} ({}:{})\n"
               "  payload    {:<12} metadata   {:<12} rtps  {} (domain rule {}, line {})\n"
               "  discovery  {:<12} liveliness {}\n"
               "  access     read {}, write {}\n",
               shown(topic), domain, row_number, '"' + shown(row.expression) + '"', file.string(),
               row.line, row.data, row.metadata, rule.rtps, rule_number, rule.line,
               effect(row.discovery, rule.discovery), effect(row.liveliness, rule.liveliness),
               asked_of(row.read_access_control), asked_of(row.write_access_control)) +
           achieves;
  }
};

using ShownDocument = std::variant<ShownGovernance, ShownTopic>;

template <class T>
std::size_t number_in(const std::vector<T>& all, const T& one) {
  return static_cast<std::size_t>(&one - all.data()) + 1;
}

// Without --domain: the first domain that is covered.
DomainId domain_for(const Governance& document, std::optional<DomainId> wanted) {
  return wanted.value_or(document.domain_rules.front().domains.ranges.front().first);
}

Result<Answer<ShownDocument>> one_topic(const Governance& document, const fs::path& file,
                                        const std::string& topic, DomainId domain) {
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
  const auto achieved = properties(*rule, *row);
  ShownTopic out{
      .file = file,
      .topic = topic,
      .domain = domain,
      .domain_rule = {DomainRuleFacts::of(*rule), number_in(document.domain_rules, *rule)},
      .topic_rule = {TopicRuleFacts::of(*row), number_in(rule->topic_rules, *row)},
      .properties = {},
      .achieves = sentence(achieved)};
  for (const auto property : governance::listed(achieved))
    out.properties.emplace_back(to_string(property));
  return Answer<ShownDocument>{std::move(out)};
}

Result<Answer<ShownDocument>> governance_show(const Arguments& arguments, const Context&) {
  const auto file = document_path<GovernanceKind>(arguments.text("FILE"));
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, domain_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<GovernanceKind>(file));
  if (arguments.has("--topic"))
    return one_topic(document, file, arguments.text("--topic"), domain_for(document, wanted));
  if (wanted && document.find(*wanted) == nullptr)
    return fail(Code::domain_not_covered,
                {.document = file, .expected = "domain " + std::to_string(*wanted)});
  if (!wanted) return Answer<ShownDocument>{ShownGovernance::of(document, file)};
  Governance part{.revision = document.revision};
  part.domain_rules.push_back(*document.find(*wanted));
  return Answer<ShownDocument>{ShownGovernance::of(part, file)};
}

std::vector<std::string> texts_of(const std::vector<governance::Text>& texts) {
  std::vector<std::string> out;
  for (const auto& text : texts) out.push_back(text.text);
  return out;
}

// Whole, unlike in a comparison: two names may differ in their last letter.
std::string joined_texts(const std::vector<std::string>& texts) {
  std::string out;
  for (const auto& text : texts)
    out += (out.empty() ? "" : ", ") + (text.empty() ? "(empty name)" : printable(text));
  return out;
}

struct DataTag {
  std::string name, value;

  static constexpr auto fields() {
    return std::tuple(field<&DataTag::name>(), field<&DataTag::value>());
  }
};

struct CriterionFacts {
  static constexpr std::string_view kDef = "criterion";
  int line;
  std::vector<std::string> topics, partitions;
  std::optional<std::vector<DataTag>> data_tags = {};
  bool has_partitions = false;  ///< also an empty list of them

  static CriterionFacts of(const governance::Criteria& criteria) {
    CriterionFacts out{.line = criteria.line,
                       .topics = texts_of(criteria.topics),
                       .partitions = {},
                       .has_partitions = criteria.partitions.has_value()};
    if (criteria.partitions) out.partitions = texts_of(*criteria.partitions);
    if (!criteria.data_tags) return out;
    out.data_tags.emplace();
    for (const auto& tag : *criteria.data_tags) out.data_tags->push_back({tag.name, tag.value});
    return out;
  }
  static constexpr auto fields() {
    using Self = CriterionFacts;
    return std::tuple(field<&Self::line>(), field<&Self::topics>(), field<&Self::partitions>(),
                      field<&Self::data_tags>({.note = "where there are some", .absent = true}));
  }
  std::string text(std::string_view action) const {
    return fmt::format("      {:<10} {}{}{}  (line {})\n", action, joined_texts(topics),
                       has_partitions ? "  in partitions " + joined_texts(partitions) : "",
                       data_tags_text(), line);
  }

 private:
  std::string data_tags_text() const {
    std::string out;
    if (!data_tags) return out;
    for (const auto& tag : *data_tags)
      out += fmt::format("{}{}={}", out.empty() ? "  with data tags " : ", ", shown(tag.name),
                         shown(tag.value));
    return out.empty() ? "  with no data tags" : out;
  }
};

std::vector<CriterionFacts> criteria_of(const std::vector<governance::Criteria>& list) {
  std::vector<CriterionFacts> out;
  std::ranges::transform(list, std::back_inserter(out), &CriterionFacts::of);
  return out;
}

struct RuleFacts {
  bool allow;
  int line;
  Json domains;
  std::vector<CriterionFacts> publish, subscribe, relay;
  // Of DDS-Security 1.2: only where there are some.
  std::optional<std::vector<std::string>> domain_tags = {}, domain_tag_expressions = {};
  std::string domain_words = {};

  static RuleFacts of(const governance::Rule& rule) {
    RuleFacts out{.allow = rule.allow,
                  .line = rule.line,
                  .domains = range_list(rule.domains),
                  .publish = criteria_of(rule.publish),
                  .subscribe = criteria_of(rule.subscribe),
                  .relay = criteria_of(rule.relay),
                  .domain_words = shown(rule.domains.ranges)};
    if (!rule.domains.tags.empty()) out.domain_tags = texts_of(rule.domains.tags);
    if (!rule.domains.tag_expressions.empty())
      out.domain_tag_expressions = texts_of(rule.domains.tag_expressions);
    return out;
  }
  static constexpr auto fields() {
    using Self = RuleFacts;
    constexpr Shown kTheSame{.note = "the same", .same = true};
    constexpr Shown kIfAny{.note = "where there are some", .absent = true};
    return std::tuple(field<&Self::allow>(), field<&Self::line>(),
                      field<&Self::domains>({.def = "domain_ranges"}), field<&Self::publish>(),
                      field<&Self::subscribe>(kTheSame), field<&Self::relay>(kTheSame),
                      field<&Self::domain_tags>(kIfAny),
                      field<&Self::domain_tag_expressions>(kIfAny));
  }
  std::string text(std::size_t number) const {
    auto out = fmt::format("  {:>2}  {:<5} {}  (line {})\n", number, allow ? "allow" : "deny",
                           domain_words, line);
    for (const auto& [action, list] :
         {std::pair("publish", &publish), std::pair("subscribe", &subscribe),
          std::pair("relay", &relay)})
      for (const auto& criterion : *list) out += criterion.text(action);
    return out;
  }
};

struct GrantFacts {
  std::string name, subject;
  int line;
  WallTime not_before, not_after;
  bool valid_now;
  std::string otherwise;
  std::vector<RuleFacts> rules = {};

  static GrantFacts of(const Grant& grant, WallTime now) {
    GrantFacts out{grant.name,
                   grant.subject_name,
                   grant.line,
                   grant.validity.not_before,
                   grant.validity.not_after,
                   grant.validity.contains(now),
                   grant.default_allow ? "ALLOW" : "DENY"};
    std::ranges::transform(grant.rules, std::back_inserter(out.rules), &RuleFacts::of);
    return out;
  }
  static constexpr auto fields() {
    using Self = GrantFacts;
    return std::tuple(
        field<&Self::name>(), field<&Self::subject>(), field<&Self::line>(),
        field<&Self::not_before>(), field<&Self::not_after>(), field<&Self::valid_now>(),
        field("default", &Self::otherwise, {.words = "ALLOW|DENY"}), field<&Self::rules>());
  }
  std::string text() const {
    auto out = fmt::format("{}  {} .. {}{}  (line {})\n", shown(subject), to_string(not_before),
                           to_string(not_after), valid_now ? "" : "  NOT VALID NOW", line);
    for (std::size_t i = 0; i < rules.size(); ++i) out += rules[i].text(i + 1);
    return out + fmt::format("      all else: {}\n", otherwise == "ALLOW" ? "ALLOWED" : "denied");
  }
};

struct ShownPermissions {
  fs::path file;
  std::vector<GrantFacts> grants = {};

  static constexpr auto fields() {
    return std::tuple(field<&ShownPermissions::file>(), field<&ShownPermissions::grants>());
  }
  std::string text() const {
    std::string out;
    for (const auto& grant : grants) out += grant.text();
    return out;
  }
};

Result<Answer<ShownPermissions>> permissions_show(const Arguments& arguments,
                                                  const Context& context) {
  const auto file = document_path<PermissionsKind>(arguments.text("FILE"));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<PermissionsKind>(file));
  std::optional<pki::SubjectName> subject;
  if (arguments.has("--subject")) {
    DDSSEC_ASSIGN_OR_RETURN(subject, pki::SubjectName::parse(arguments.text("--subject")));
  }
  Answer<ShownPermissions> out{{file}};
  for (const auto& grant : document.grants)
    if (!subject || is_for(grant, *subject))
      out.result.grants.push_back(GrantFacts::of(grant, context.clock.now()));
  if (subject && out.result.grants.empty())
    return fail(Code::no_grant_for_subject,
                {.document = file, .expected = arguments.text("--subject")});
  return out;
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
