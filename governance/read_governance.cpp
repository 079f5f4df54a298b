#include <utility>

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
  DDSSEC_ASSIGN_OR_RETURN(const auto child, XmlChildren::of(element, kSpecs));
  if (!child.in_order())
    context.note(NoteKind::order, element, "is not in the schema's order: Fast DDS refuses it");
  TopicRule rule;
  rule.line = element.line();
  note_padding(context, child.one(0));
  rule.is_padded = child.one(0).is_padded();
  DDSSEC_ASSIGN_OR_RETURN(rule.topic_expression, child.one(0).nonempty_text());
  DDSSEC_ASSIGN_OR_RETURN(rule.enable_discovery_protection, read_boolean(context, child.one(1)));
  DDSSEC_ASSIGN_OR_RETURN(rule.enable_liveliness_protection, read_boolean(context, child.one(2)));
  DDSSEC_ASSIGN_OR_RETURN(rule.enable_read_access_control, read_boolean(context, child.one(3)));
  DDSSEC_ASSIGN_OR_RETURN(rule.enable_write_access_control, read_boolean(context, child.one(4)));
  DDSSEC_ASSIGN_OR_RETURN(rule.metadata_protection_kind,
                          read_protection_kind(context, child.one(5), AllowedKinds::all));
  DDSSEC_ASSIGN_OR_RETURN(rule.data_protection_kind,
                          read_protection_kind(context, child.one(6), AllowedKinds::basic));
  return rule;
}

Result<std::vector<TopicRule>> read_topic_rules(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"topic_rule", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  std::vector<TopicRule> rules;
  rules.reserve(children.all().size());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    DDSSEC_ASSIGN_OR_RETURN(auto topic_rule, read_topic_rule(context, child));
    rules.push_back(std::move(topic_rule));
  }
  if (rules.empty()) {
    return fail(
        Code::element_missing,
        {.line = element.line(), .field = "<topic_access_rules>", .expected = "<topic_rule>"});
  }
  return rules;
}

// One of the lists of allowed_crypto_algorithms.
struct AlgorithmList {
  std::string_view name;
  std::span<const std::string_view> if_absent;
};

// An absent list allows the algorithms that the standard names (10.4.1.2.5.9.1, .3, .4), although
// the standard's schema requires the list.
Result<std::vector<Text>> read_algorithm_list(ReadContext& context, XmlElement section,
                                              XmlElement element, const AlgorithmList& list) {
  if (element) return read_texts(context, element, "algorithm");
  context.note(NoteKind::no_algorithms, section,
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
  DDSSEC_ASSIGN_OR_RETURN(const auto child, XmlChildren::of(element, kSpecs));
  if (child.one(1) && child.one(2)) {
    return fail(Code::element_repeated,
                {.line = child.one(2).line(), .field = "<digital_signature_trust_chain>"});
  }
  AllowedAlgorithms allowed{.line = element.line()};
  const XmlElement trust_chain = child.one(1) ? child.one(1) : child.one(2);
  const auto list = [&](std::size_t at, std::span<const std::string_view> if_absent) {
    return read_algorithm_list(context, element, child.one(at), {kSpecs[at].name, if_absent});
  };
  DDSSEC_ASSIGN_OR_RETURN(allowed.digital_signature, list(0, kStandardSignatures));
  if (trust_chain) {
    DDSSEC_ASSIGN_OR_RETURN(allowed.digital_signature_identity_trust_chain,
                            read_texts(context, trust_chain, "algorithm"));
  }
  DDSSEC_ASSIGN_OR_RETURN(allowed.key_establishment, list(3, kStandardKeyEstablishments));
  DDSSEC_ASSIGN_OR_RETURN(allowed.symmetric_cipher, list(4, kStandardCiphers));
  return allowed;
}

// The rows of a domain_rule, in the order of the 1.2 schema.
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

// The elements that only DDS-Security 1.2 knows; 1.1 documents lack them.
Status read_additions(ReadContext& context, const XmlChildren& child, DomainRule& rule) {
  if (const auto e = child.one(kKeyRevision)) {
    DDSSEC_ASSIGN_OR_RETURN(rule.enable_key_revision, read_boolean(context, e));
  }
  if (const auto e = child.one(kRtpsPsk)) {
    DDSSEC_ASSIGN_OR_RETURN(rule.rtps_psk_protection_kind,
                            read_protection_kind(context, e, AllowedKinds::basic));
  }
  if (const auto e = child.one(kAlgorithms)) {
    DDSSEC_ASSIGN_OR_RETURN(rule.allowed_algorithms, read_algorithms(context, e));
  }
  return {};
}

Result<DomainRule> read_domain_rule(ReadContext& context, XmlElement element) {
  DDSSEC_ASSIGN_OR_RETURN(const auto child, XmlChildren::of(element, kDomainRuleSpecs));
  if (!child.in_order())
    context.note(NoteKind::order, element, "is not in the schema's order: Fast DDS refuses it");
  DomainRule rule;
  rule.line = element.line();
  DDSSEC_ASSIGN_OR_RETURN(rule.domains, read_domains(context, child.one(kDomains)));
  DDSSEC_ASSIGN_OR_RETURN(rule.allow_unauthenticated_participants,
                          read_boolean(context, child.one(kAllowUnauthenticated)));
  DDSSEC_ASSIGN_OR_RETURN(rule.enable_join_access_control,
                          read_boolean(context, child.one(kJoinAccessControl)));
  DDSSEC_ASSIGN_OR_RETURN(rule.discovery_protection_kind,
                          read_protection_kind(context, child.one(kDiscovery), AllowedKinds::all));
  DDSSEC_ASSIGN_OR_RETURN(rule.liveliness_protection_kind,
                          read_protection_kind(context, child.one(kLiveliness), AllowedKinds::all));
  DDSSEC_ASSIGN_OR_RETURN(rule.rtps_protection_kind,
                          read_protection_kind(context, child.one(kRtps), AllowedKinds::all));
  DDSSEC_RETURN_IF_ERROR(read_additions(context, child, rule));
  DDSSEC_ASSIGN_OR_RETURN(rule.topic_rules, read_topic_rules(context, child.one(kTopicRules)));
  return rule;
}

}  // namespace

Result<Governance> read_governance(BytesView xml, int first_line) {
  constexpr ChildSpec kSpecs[] = {{"domain_rule", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto document, XmlDocument::parse(xml, first_line));
  DDSSEC_ASSIGN_OR_RETURN(const auto body, document_body(document, "domain_access_rules"));
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(body, kSpecs));
  Governance governance;
  governance.revision = document.revision();
  ReadContext context(governance.notes);
  note_byte_order_mark(context, xml, document.root());
  note_end_tags(context, xml, first_line);
  note_extensions(context, document.root());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    DDSSEC_ASSIGN_OR_RETURN(auto domain_rule, read_domain_rule(context, child));
    governance.domain_rules.push_back(std::move(domain_rule));
  }
  if (governance.domain_rules.empty()) {
    return fail(
        Code::element_missing,
        {.line = body.line(), .field = "<domain_access_rules>", .expected = "<domain_rule>"});
  }
  return governance;
}

}  // namespace ddssec::governance
