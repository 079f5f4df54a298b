#include "governance/compare/governance_elements.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "governance/standard_algorithms.hpp"

namespace ddssec::governance {
namespace {

int level(ProtectionKind kind) { return is_encrypted(kind) ? 2 : is_protected(kind) ? 1 : 0; }

ChangeClass moved(bool up, bool down) {
  if (up && down) return ChangeClass::mixed;
  return up ? ChangeClass::stronger : down ? ChangeClass::weaker : ChangeClass::neutral;
}

std::string_view word(bool value) { return value ? "true" : "false"; }
std::string_view covered(const void* rule) { return rule ? "covered" : "uncovered"; }

// Collects the differences.
class Changes {
 public:
  void add_coverage(std::string_view element, const void* old_rule, const void* new_rule,
                    Interop interop) {
    if ((old_rule == nullptr) == (new_rule == nullptr)) return;
    const auto change = old_rule ? ChangeClass::narrower : ChangeClass::wider;
    add({element, std::string(covered(old_rule)), std::string(covered(new_rule)), change, interop});
  }
  void add_kind(std::string_view element, ProtectionKind old_kind, ProtectionKind new_kind,
                Interop interop) {
    if (old_kind == new_kind) return;
    add({element, std::string(ddssec::to_string(old_kind)),
         std::string(ddssec::to_string(new_kind)), compare_kinds(old_kind, new_kind), interop});
  }
  void add_flag(std::string_view element, bool old_value, bool new_value, ChangeClass if_true,
                ChangeClass if_false, Interop interop) {
    if (old_value == new_value) return;
    add({element, std::string(word(old_value)), std::string(word(new_value)),
         new_value ? if_true : if_false, interop});
  }
  void add(ElementChange change) { changes_.push_back(std::move(change)); }
  std::vector<ElementChange> take() { return std::move(changes_); }

 private:
  std::vector<ElementChange> changes_;
};

using Names = std::set<std::string_view>;

// Every algorithm that the standard names for a purpose.
Names all_signatures() { return {kStandardSignatures.begin(), kStandardSignatures.end()}; }
Names all_key_establishments() {
  return {kStandardKeyEstablishments.begin(), kStandardKeyEstablishments.end()};
}
Names all_ciphers() { return {kStandardCiphers.begin(), kStandardCiphers.end()}; }

Names names_in(const std::vector<Text>& texts) {
  Names names;
  for (const auto& text : texts) names.insert(text.text);
  return names;
}

Names listed_or(const DomainRule& rule, std::vector<Text> AllowedAlgorithms::*list,
                const Names& if_absent) {
  if (!rule.allowed_algorithms || ((*rule.allowed_algorithms).*list).empty()) return if_absent;
  return names_in((*rule.allowed_algorithms).*list);
}

Names signatures(const DomainRule& rule) {
  return listed_or(rule, &AllowedAlgorithms::digital_signature, all_signatures());
}
Names trust_chain(const DomainRule& rule) {
  return listed_or(rule, &AllowedAlgorithms::digital_signature_identity_trust_chain,
                   signatures(rule));
}
Names key_establishments(const DomainRule& rule) {
  return listed_or(rule, &AllowedAlgorithms::key_establishment, all_key_establishments());
}
Names ciphers(const DomainRule& rule) {
  return listed_or(rule, &AllowedAlgorithms::symmetric_cipher, all_ciphers());
}

std::string text_of(const Names& names, const Names& all) {
  if (names == all) return "every algorithm";
  std::string text;
  for (const auto name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

// Fewer algorithms are stronger; without a common one no two participants can communicate.
void add_algorithms(Changes& changes, std::string_view element, const Names& all,
                    const Names& old_names, const Names& new_names) {
  if (old_names == new_names) return;
  const bool up = !std::ranges::includes(new_names, old_names);
  const bool down = !std::ranges::includes(old_names, new_names);
  const bool common = std::ranges::any_of(
      old_names, [&](std::string_view name) { return new_names.contains(name); });
  changes.add({element, text_of(old_names, all), text_of(new_names, all), moved(up, down),
               common ? Interop::none : Interop::participant});
}

struct AlgorithmList {
  std::string_view element;
  Names (*allowed)(const DomainRule&);
  Names (*all)();
};
constexpr std::array<AlgorithmList, 4> kAlgorithmLists = {{
    {"allowed_crypto_algorithms/digital_signature", signatures, all_signatures},
    {"allowed_crypto_algorithms/digital_signature_identity_trust_chain", trust_chain,
     all_signatures},
    {"allowed_crypto_algorithms/key_establishment", key_establishments, all_key_establishments},
    {"allowed_crypto_algorithms/symmetric_cipher", ciphers, all_ciphers},
}};

}  // namespace

std::string_view to_string(Interop interop) {
  constexpr std::array<std::string_view, 3> kNames = {"none", "participant", "endpoint"};
  return kNames.at(static_cast<std::size_t>(interop));
}

ChangeClass compare_kinds(ProtectionKind old_kind, ProtectionKind new_kind) {
  const int levels = level(new_kind) - level(old_kind);
  const int origin = is_origin_authenticated(new_kind) - is_origin_authenticated(old_kind);
  return moved(levels > 0 || origin > 0, levels < 0 || origin < 0);
}

std::vector<ElementChange> compare_domain_rules(const DomainRule* old_rule,
                                                const DomainRule* new_rule) {
  using enum ChangeClass;
  Changes changes;
  changes.add_coverage("domain_rule", old_rule, new_rule, Interop::participant);
  if (!old_rule || !new_rule) return changes.take();
  const DomainRule& o = *old_rule;
  const DomainRule& n = *new_rule;
  changes.add_flag("allow_unauthenticated_participants", o.allow_unauthenticated_participants,
                   n.allow_unauthenticated_participants, weaker, stronger, Interop::none);
  changes.add_flag("enable_join_access_control", o.enable_join_access_control,
                   n.enable_join_access_control, stronger, weaker, Interop::none);
  changes.add_flag("enable_key_revision", o.enable_key_revision, n.enable_key_revision, stronger,
                   weaker, Interop::participant);
  changes.add_kind("discovery_protection_kind", o.discovery_protection_kind,
                   n.discovery_protection_kind, Interop::participant);
  changes.add_kind("liveliness_protection_kind", o.liveliness_protection_kind,
                   n.liveliness_protection_kind, Interop::participant);
  changes.add_kind("rtps_protection_kind", o.rtps_protection_kind, n.rtps_protection_kind,
                   Interop::participant);
  changes.add_kind("rtps_psk_protection_kind", o.rtps_psk_protection_kind,
                   n.rtps_psk_protection_kind, Interop::participant);
  for (const auto& row : kAlgorithmLists) {
    add_algorithms(changes, row.element, row.all(), row.allowed(o), row.allowed(n));
  }
  return changes.take();
}

std::vector<ElementChange> compare_topic_rules(const TopicRules& rules) {
  using enum ChangeClass;
  Changes changes;
  changes.add_coverage("topic_rule", rules.old_rule, rules.new_rule, Interop::endpoint);
  if (!rules.old_rule || !rules.new_rule) return changes.take();
  const TopicRule& o = *rules.old_rule;
  const TopicRule& n = *rules.new_rule;
  // A flag without effect protects nothing, but it is still announced and compared.
  const auto add_protection = [&](std::string_view element, bool TopicRule::*flag,
                                  ProtectionKind DomainRule::*kind) {
    const bool effective = is_protected((n.*flag ? rules.new_domain : rules.old_domain).*kind);
    changes.add_flag(element, o.*flag, n.*flag, effective ? stronger : neutral,
                     effective ? weaker : neutral, Interop::endpoint);
  };
  add_protection("enable_discovery_protection", &TopicRule::enable_discovery_protection,
                 &DomainRule::discovery_protection_kind);
  add_protection("enable_liveliness_protection", &TopicRule::enable_liveliness_protection,
                 &DomainRule::liveliness_protection_kind);
  changes.add_flag("enable_read_access_control", o.enable_read_access_control,
                   n.enable_read_access_control, stronger, weaker, Interop::endpoint);
  changes.add_flag("enable_write_access_control", o.enable_write_access_control,
                   n.enable_write_access_control, stronger, weaker, Interop::endpoint);
  changes.add_kind("metadata_protection_kind", o.metadata_protection_kind,
                   n.metadata_protection_kind, Interop::endpoint);
  changes.add_kind("data_protection_kind", o.data_protection_kind, n.data_protection_kind,
                   Interop::endpoint);
  return changes.take();
}

}  // namespace ddssec::governance
