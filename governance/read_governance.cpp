#include <fmt/format.h>

#include "governance/read.hpp"
#include "governance/read_values.hpp"
#include "governance/standard_algorithms.hpp"

namespace ddssec::governance {
namespace {

using Count = ChildSpec::Count;

Result<TopicRule> read_topic_rule(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"topic_expression"},
                                  {"enable_discovery_protection"},
                                  {"enable_liveliness_protection"},
                                  {"enable_read_access_control"},
                                  {"enable_write_access_control"},
                                  {"metadata_protection_kind"},
                                  {"data_protection_kind"}};
  const auto child = DDSSEC_TRY(XmlChildren::of(element, kSpecs));
  if (!child.in_order())
    context.note(NoteKind::order, element, "is not in the schema's order: Fast DDS refuses it");
  TopicRule rule;
  rule.line = element.line();
  note_padding(context, child.one(0));
  rule.is_padded = child.one(0).is_padded();
  rule.topic_expression = DDSSEC_TRY(child.one(0).nonempty_text());
  rule.enable_discovery_protection = DDSSEC_TRY(read_boolean(context, child.one(1)));
  rule.enable_liveliness_protection = DDSSEC_TRY(read_boolean(context, child.one(2)));
  rule.enable_read_access_control = DDSSEC_TRY(read_boolean(context, child.one(3)));
  rule.enable_write_access_control = DDSSEC_TRY(read_boolean(context, child.one(4)));
  rule.metadata_protection_kind = DDSSEC_TRY(read_protection_kind(context, child.one(5), false));
  rule.data_protection_kind = DDSSEC_TRY(read_protection_kind(context, child.one(6), true));
  return rule;
}

Result<std::vector<TopicRule>> read_topic_rules(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"topic_rule", Count::many}};
  const auto children = DDSSEC_TRY(XmlChildren::of(element, kSpecs));
  std::vector<TopicRule> rules;
  rules.reserve(children.all().size());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_TRY(context.count(child));
    rules.push_back(DDSSEC_TRY(read_topic_rule(context, child)));
  }
  if (rules.empty()) {
    return fail(
        Code::element_missing,
        {.line = element.line(), .field = "<topic_access_rules>", .expected = "<topic_rule>"});
  }
  return rules;
}

/// One of the lists of allowed_crypto_algorithms.
struct AlgorithmList {
  std::string_view name;
  std::span<const std::string_view> if_absent;
};

/// An absent list allows what the standard names (10.4.1.2.5.9.1, .3, .4), whatever its schema
/// says.
Result<std::vector<Text>> read_algorithm_list(ReadContext& context, XmlElement section,
                                              XmlElement element, const AlgorithmList& list) {
  if (element) return read_texts(context, element, "algorithm");
  context.note(NoteKind::extension, section,
               fmt::format("has no <{}>: every algorithm of DDS-Security 1.2 is allowed; a product "
                           "that follows the schema, which requires it, refuses the document",
                           list.name));
  std::vector<Text> out;
  for (const auto name : list.if_absent) out.push_back({std::string(name), section.line()});
  return out;
}

Result<AllowedAlgorithms> read_algorithms(ReadContext& context, XmlElement element) {
  // The standard's example once calls the second one digital_signature_trust_chain.
  constexpr ChildSpec kSpecs[] = {{"digital_signature", Count::optional},
                                  {"digital_signature_identity_trust_chain", Count::optional},
                                  {"digital_signature_trust_chain", Count::optional},
                                  {"key_establishment", Count::optional},
                                  {"symmetric_cipher", Count::optional}};
  const auto child = DDSSEC_TRY(XmlChildren::of(element, kSpecs));
  if (child.one(1) && child.one(2)) {
    return fail(Code::element_repeated,
                {.line = child.one(2).line(), .field = "<digital_signature_trust_chain>"});
  }
  AllowedAlgorithms allowed{.line = element.line()};
  const XmlElement trust_chain = child.one(1) ? child.one(1) : child.one(2);
  const auto list = [&](std::size_t at, std::span<const std::string_view> if_absent) {
    return read_algorithm_list(context, element, child.one(at), {kSpecs[at].name, if_absent});
  };
  allowed.digital_signature = DDSSEC_TRY(list(0, kStandardSignatures));
  if (trust_chain) {
    allowed.digital_signature_identity_trust_chain =
        DDSSEC_TRY(read_texts(context, trust_chain, "algorithm"));
  }
  allowed.key_establishment = DDSSEC_TRY(list(3, kStandardKeyEstablishments));
  allowed.symmetric_cipher = DDSSEC_TRY(list(4, kStandardCiphers));
  return allowed;
}

/// The rows of a domain_rule, in the order of the 1.2 schema.
enum DomainRuleChild : std::size_t {
  kDomains,
  kAllowUnauthenticated,
  kJoinAccessControl,
  kKeyRevision,
  kDiscovery,
  kLiveliness,
  kRtps,
  kRtpsPsk,
  kTopicRules,
  kAlgorithms,
};

constexpr ChildSpec kDomainRuleSpecs[] = {{"domains"},
                                          {"allow_unauthenticated_participants"},
                                          {"enable_join_access_control"},
                                          {"enable_key_revision", Count::optional},
                                          {"discovery_protection_kind"},
                                          {"liveliness_protection_kind"},
                                          {"rtps_protection_kind"},
                                          {"rtps_psk_protection_kind", Count::optional},
                                          {"topic_access_rules"},
                                          {"allowed_crypto_algorithms", Count::optional}};

/// The elements that only DDS-Security 1.2 knows; 1.1 documents lack them.
Status read_additions(ReadContext& context, const XmlChildren& child, DomainRule& rule) {
  if (const auto e = child.one(kKeyRevision)) {
    rule.enable_key_revision = DDSSEC_TRY(read_boolean(context, e));
  }
  if (const auto e = child.one(kRtpsPsk)) {
    rule.rtps_psk_protection_kind = DDSSEC_TRY(read_protection_kind(context, e, true));
  }
  if (const auto e = child.one(kAlgorithms)) {
    rule.allowed_algorithms = DDSSEC_TRY(read_algorithms(context, e));
  }
  return {};
}

Result<DomainRule> read_domain_rule(ReadContext& context, XmlElement element) {
  const auto child = DDSSEC_TRY(XmlChildren::of(element, kDomainRuleSpecs));
  if (!child.in_order())
    context.note(NoteKind::order, element, "is not in the schema's order: Fast DDS refuses it");
  DomainRule rule;
  rule.line = element.line();
  rule.domains = DDSSEC_TRY(read_domains(context, child.one(kDomains)));
  rule.allow_unauthenticated_participants =
      DDSSEC_TRY(read_boolean(context, child.one(kAllowUnauthenticated)));
  rule.enable_join_access_control =
      DDSSEC_TRY(read_boolean(context, child.one(kJoinAccessControl)));
  rule.discovery_protection_kind =
      DDSSEC_TRY(read_protection_kind(context, child.one(kDiscovery), false));
  rule.liveliness_protection_kind =
      DDSSEC_TRY(read_protection_kind(context, child.one(kLiveliness), false));
  rule.rtps_protection_kind = DDSSEC_TRY(read_protection_kind(context, child.one(kRtps), false));
  DDSSEC_TRY(read_additions(context, child, rule));
  rule.topic_rules = DDSSEC_TRY(read_topic_rules(context, child.one(kTopicRules)));
  return rule;
}

}  // namespace

Result<Governance> read_governance(BytesView xml, int first_line) {
  constexpr ChildSpec kSpecs[] = {{"domain_rule", Count::many}};
  const auto document = DDSSEC_TRY(XmlDocument::parse(xml, first_line));
  const auto body = DDSSEC_TRY(document_body(document, "domain_access_rules"));
  const auto children = DDSSEC_TRY(XmlChildren::of(body, kSpecs));
  Governance governance;
  ReadContext context(governance.notes);
  note_byte_order_mark(context, xml, document.root());
  note_end_tags(context, xml, first_line);
  note_extensions(context, document.root());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_TRY(context.count(child));
    governance.domain_rules.push_back(DDSSEC_TRY(read_domain_rule(context, child)));
  }
  if (governance.domain_rules.empty()) {
    return fail(
        Code::element_missing,
        {.line = body.line(), .field = "<domain_access_rules>", .expected = "<domain_rule>"});
  }
  return governance;
}

}  // namespace ddssec::governance
