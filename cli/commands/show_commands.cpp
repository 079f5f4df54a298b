// governance show, permissions show: display the effect of a document.
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/commands/groups.hpp"
#include "cli/diff/diff_words.hpp"
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
using governance::ProtectionProperty;
using governance::TopicRule;

Json range_list(const governance::DomainSet& domains) { return domains_json(domains.ranges); }

std::optional<ProtectionKind> if_protected(ProtectionKind kind) {
  return is_protected(kind) ? std::optional(kind) : std::nullopt;
}

std::optional<bool> if_set(bool flag) { return flag ? std::optional(flag) : std::nullopt; }

constexpr FieldOptions kKind{.def = "protection_kind"};

}  // namespace

template <>
struct FieldsOf<TopicRule> {
  using T = TopicRule;
  static constexpr std::string_view kDef = "topic_rule";
  static constexpr auto fields() {
    return std::tuple(field("expression", &T::topic_expression), field<&T::line>(),
                      field("data", &T::data_protection_kind, kKind),
                      field("metadata", &T::metadata_protection_kind, kKind),
                      field("discovery", &T::enable_discovery_protection),
                      field("liveliness", &T::enable_liveliness_protection),
                      field("read_access_control", &T::enable_read_access_control),
                      field("write_access_control", &T::enable_write_access_control));
  }
};

// A domain rule without its topic rules.
template <>
struct FieldsOf<DomainRule> {
  using T = DomainRule;
  static constexpr auto fields() {
    return std::tuple(
        field("domains", &T::domains, range_list, {.def = "domain_ranges"}), field<&T::line>(),
        field("allow_unauthenticated", &T::allow_unauthenticated_participants),
        field("join_access_control", &T::enable_join_access_control),
        field("discovery", &T::discovery_protection_kind, kKind),
        field("liveliness", &T::liveliness_protection_kind, kKind),
        field("rtps", &T::rtps_protection_kind, kKind),
        // A kind of DDS-Security 1.2. Absent if there is none, as in all domains without
        // embedded participants.
        field("pre_shared_key", &T::rtps_psk_protection_kind, if_protected,
              {.note = "if there is one", .words = "SIGN|ENCRYPT", .omits_empty = true}),
        field("key_revision", &T::enable_key_revision, if_set,
              {.note = "if keys are revised", .omits_empty = true}));
  }
};

namespace {

std::string newer_elements(const DomainRule& rule) {
  std::string out;
  if (is_protected(rule.rtps_psk_protection_kind))
    out += fmt::format("  pre-shared key {}", to_string(rule.rtps_psk_protection_kind));
  if (rule.enable_key_revision) out += "  keys are revised";
  return out;
}

std::string_view yes(bool value) { return value ? "yes" : "no"; }

std::string topic_row(const TopicRule& rule, std::size_t number) {
  return fmt::format(
      "  {:>4}  {:<40} data {:<8} metadata {:<8} read {} write {} discovery {} "
      "(line {})\n",
      number, name_text(rule.topic_expression), to_string(rule.data_protection_kind),
      to_string(rule.metadata_protection_kind),
      rule.enable_read_access_control ? "by permission" : "free",
      rule.enable_write_access_control ? "by permission" : "free",
      rule.enable_discovery_protection ? "protected" : "open", rule.line);
}

struct ShownDomainRule {
  DomainRule rule;

  static constexpr auto fields() {
    return std::tuple_cat(
        fields_within(&ShownDomainRule::rule),
        std::tuple(field("topic_rules", &ShownDomainRule::rule, &DomainRule::topic_rules)));
  }
  std::string text(std::size_t number, const fs::path& file) const {
    auto out = fmt::format(
        "domain rule {}: {} ({}:{})\n"
        "  discovery {}  liveliness {}  rtps {}{}\n"
        "  strangers {}, permissions needed to join: {}\n",
        number, domains_text(rule.domains.ranges), file.string(), rule.line,
        to_string(rule.discovery_protection_kind), to_string(rule.liveliness_protection_kind),
        to_string(rule.rtps_protection_kind), newer_elements(rule),
        rule.allow_unauthenticated_participants ? "allowed" : "refused",
        yes(rule.enable_join_access_control));
    for (std::size_t i = 0; i < rule.topic_rules.size(); ++i)
      out += topic_row(rule.topic_rules[i], i + 1);
    return out;
  }
};

struct ShownGovernance {
  fs::path file;
  std::vector<ShownDomainRule> domain_rules = {};
  std::optional<std::size_t> revision = {};

  static ShownGovernance of(const Governance& document, const fs::path& file) {
    ShownGovernance out{file};
    for (const auto& rule : document.domain_rules) out.domain_rules.push_back({rule});
    if (document.revision != 0) out.revision = document.revision;
    return out;
  }
  static constexpr auto fields() {
    using Self = ShownGovernance;
    return std::tuple(
        field<&Self::file>(), field<&Self::domain_rules>({.min = 1}),
        field<&Self::revision>({.note = "if it has one", .def = "revision", .omits_empty = true}));
  }
  std::string text() const {
    auto out = revision ? fmt::format("revision {}\n", *revision) : "";
    for (std::size_t i = 0; i < domain_rules.size(); ++i) out += domain_rules[i].text(i + 1, file);
    return out;
  }
};

// A rule and its position in the document.
template <class Facts>
struct NumberedRule {
  Facts rule;
  std::size_t number;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&NumberedRule::rule),
                          std::tuple(field<&NumberedRule::number>()));
  }
};

bool has(const governance::Properties& properties, ProtectionProperty property) {
  return properties.test(static_cast<std::size_t>(property));
}

std::string achieved(bool secret, bool authentic) {
  if (!secret && !authentic) return "nothing";
  return fmt::format("{}{}{}", secret ? "confidential" : "", secret && authentic ? ", " : "",
                     authentic ? "authentic" : "");
}

std::string sentence(const governance::Properties& p) {
  using enum ProtectionProperty;
  return fmt::format(
      "  against outsiders: {}   against insiders without the right: {}\n"
      "  against relays: {}\n",
      achieved(has(p, outsider_payload_secrecy), has(p, outsider_payload_integrity)),
      achieved(has(p, insider_payload_secrecy), has(p, insider_payload_integrity)),
      achieved(has(p, relay_payload_secrecy), has(p, relay_payload_integrity)));
}

// The requirement for reading or writing a topic.
std::string_view access_requirement(bool access_control) {
  return access_control ? "by permission" : "free: every participant of the domain";
}

std::string_view effect(bool flag, ProtectionKind kind) {
  return flag && is_protected(kind) ? "protected" : "open";
}

// The rules that decide for one topic of one domain.
struct ShownTopic {
  static constexpr std::string_view kWhen = "with --topic";
  fs::path file;
  std::string topic;
  DomainId domain;
  NumberedRule<DomainRule> domain_rule;
  NumberedRule<TopicRule> topic_rule;
  std::vector<std::string> properties;
  std::string achieves;  // the properties in words: complete lines

  static constexpr auto fields() {
    using Self = ShownTopic;
    return std::tuple(
        field<&Self::file>(), field<&Self::topic>(), field<&Self::domain>(),
        field<&Self::domain_rule>(
            {.note = "the same without `topic_rules`, and `number`", .has_same_members = true}),
        field<&Self::topic_rule>({.note = "the same, and `number`", .has_same_members = true}),
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
               name_text(topic), domain, row_number, '"' + name_text(row.topic_expression) + '"',
               file.string(), row.line, to_string(row.data_protection_kind),
               to_string(row.metadata_protection_kind), to_string(rule.rtps_protection_kind),
               rule_number, rule.line,
               effect(row.enable_discovery_protection, rule.discovery_protection_kind),
               effect(row.enable_liveliness_protection, rule.liveliness_protection_kind),
               access_requirement(row.enable_read_access_control),
               access_requirement(row.enable_write_access_control)) +
           achieves;
  }
};

using ShownDocument = std::variant<ShownGovernance, ShownTopic>;

template <class T>
std::size_t number_in(const std::vector<T>& all, const T& one) {
  return static_cast<std::size_t>(&one - all.data()) + 1;
}

// Returns the value of --domain, or else the first domain that the document covers.
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
  ShownTopic out{.file = file,
                 .topic = topic,
                 .domain = domain,
                 .domain_rule = {*rule, number_in(document.domain_rules, *rule)},
                 .topic_rule = {*row, number_in(rule->topic_rules, *row)},
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

// Shows the whole texts, unlike in a comparison, because two names may differ only in their last
// letter.
std::string joined_texts(const std::vector<std::string>& texts) {
  std::string out;
  for (const auto& text : texts)
    out += (out.empty() ? "" : ", ") + (text.empty() ? "(empty name)" : printable(text));
  return out;
}

std::string data_tags_text(const governance::Criteria& criteria) {
  if (!criteria.data_tags) return {};
  std::string out;
  for (const auto& tag : *criteria.data_tags)
    out += fmt::format("{}{}={}", out.empty() ? "  with data tags " : ", ", name_text(tag.name),
                       name_text(tag.value));
  return out.empty() ? "  with no data tags" : out;
}

std::string text_of(const governance::Criteria& criteria, std::string_view action) {
  return fmt::format(
      "      {:<10} {}{}{}  (line {})\n", action, joined_texts(texts_of(criteria.topics)),
      criteria.partitions ? "  in partitions " + joined_texts(texts_of(*criteria.partitions)) : "",
      data_tags_text(criteria), criteria.line);
}

std::optional<std::vector<std::string>> texts_if_any(const std::vector<governance::Text>& texts) {
  return texts.empty() ? std::nullopt : std::optional(texts_of(texts));
}

}  // namespace

template <>
struct FieldsOf<governance::Criteria> {
  using T = governance::Criteria;
  static constexpr std::string_view kDef = "criterion";
  static constexpr auto fields() {
    return std::tuple(field<&T::line>(), field("topics", &T::topics, texts_of),
                      computed<T>("partitions",
                                  [](const T& one) {
                                    return one.partitions ? texts_of(*one.partitions)
                                                          : std::vector<std::string>();
                                  }),
                      field<&T::data_tags>({.note = "where there are some", .omits_empty = true}));
  }
};

template <>
struct FieldsOf<governance::GrantRule> {
  using T = governance::GrantRule;
  static constexpr auto fields() {
    constexpr FieldOptions kTheSame{.note = "the same", .has_same_members = true};
    // Texts of DDS-Security 1.2, shown only if there are some.
    constexpr FieldOptions kIfAny{.note = "where there are some", .omits_empty = true};
    return std::tuple(
        field<&T::allow>(), field<&T::line>(),
        field("domains", &T::domains, range_list, {.def = "domain_ranges"}), field<&T::publish>(),
        field<&T::subscribe>(kTheSame), field<&T::relay>(kTheSame),
        computed<T>(
            "domain_tags", [](const T& one) { return texts_if_any(one.domains.tags); }, kIfAny),
        computed<T>(
            "domain_tag_expressions",
            [](const T& one) { return texts_if_any(one.domains.tag_expressions); }, kIfAny));
  }
};

namespace {

std::string text_of(const governance::GrantRule& rule, std::size_t number) {
  auto out = fmt::format("  {:>2}  {:<5} {}  (line {})\n", number, rule.allow ? "allow" : "deny",
                         domains_text(rule.domains.ranges), rule.line);
  for (const auto& [action, list] :
       {std::pair("publish", &rule.publish), std::pair("subscribe", &rule.subscribe),
        std::pair("relay", &rule.relay)})
    for (const auto& criteria : *list) out += text_of(criteria, action);
  return out;
}

struct ShownGrant {
  Grant grant;
  bool valid_now;

  static constexpr auto fields() {
    using T = ShownGrant;
    return std::tuple(
        field("name", &T::grant, &Grant::name), field("subject", &T::grant, &Grant::subject_name),
        field("line", &T::grant, &Grant::line),
        computed<T>("not_before", [](const T& one) { return one.grant.validity.not_before; }),
        computed<T>("not_after", [](const T& one) { return one.grant.validity.not_after; }),
        field<&T::valid_now>(),
        computed<T>("default",
                    [](const T& one) { return one.grant.default_allow ? "ALLOW" : "DENY"; },
                    {.words = "ALLOW|DENY"}),
        field("rules", &T::grant, &Grant::rules));
  }
  std::string text() const {
    auto out =
        fmt::format("{}  {} .. {}{}  (line {})\n", name_text(grant.subject_name),
                    to_string(grant.validity.not_before), to_string(grant.validity.not_after),
                    valid_now ? "" : "  NOT VALID NOW", grant.line);
    for (std::size_t i = 0; i < grant.rules.size(); ++i) out += text_of(grant.rules[i], i + 1);
    return out + fmt::format("      all else: {}\n", grant.default_allow ? "ALLOWED" : "denied");
  }
};

struct ShownPermissions {
  fs::path file;
  std::vector<ShownGrant> grants = {};

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
      out.result.grants.push_back(
          {grant, grant.validity.contains(context.clock.calendar_seconds())});
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
           .run = governance_show,
           .instead_of_extra = "--topic names a topic"},
          {.group = "permissions",
           .name = "show",
           .summary = "Shows who may publish and subscribe what, and until when.",
           .positionals = {kDocument},
           .options = {{"--subject", "DN", "for this subject only"}},
           .examples = {"ddssec permissions show permissions.p7s --subject CN=talker"},
           .run = permissions_show}};
}

}  // namespace ddssec::cli
