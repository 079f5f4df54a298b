// Predicts a product's decisions for a grant, where they differ from the standard.
#pragma once

#include <string_view>
#include <vector>

#include "governance/decision.hpp"
#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {

/// True if `product` matches a name with an expression: products read bracket expressions and
/// backslashes differently (dialect.hpp), and Fast DDS keeps the blanks around an expression.
bool matches_as(Product product, const Text& expression, std::string_view name);

/// Returns the first element of the list that names the topic as `product` reads it, or nullptr.
const Criteria* naming(Product product, const std::vector<Criteria>& list, std::string_view topic);

/// Returns the domain_rule that `product` applies in the domain, or nullptr.
const DomainRule* domain_rule_as(Product product, const Governance& governance, DomainId domain);

/// Returns the first topic_rule for the topic as `product` reads them, or nullptr.
const TopicRule* topic_rule_as(Product product, const DomainRule& domain, std::string_view topic);

/// Returns the rule by which Cyclone DDS 0.10 decides whether a topic may be created at all: the
/// first one for the domain that names it in any direction. nullptr if none does.
const governance::GrantRule* first_rule_naming(const Grant& grant, DomainId domain,
                                               std::string_view topic);

/// Judges like CompiledGrant::judge, but with the decision of `product` in `domain`, and with
/// expressions as it reads them. Cyclone DDS applies a deny_rule without partitions to the
/// partition "" only. With Fast DDS the first rule whose topic matches decides, whatever its
/// partitions are: a deny_rule denies in all of them, and an allow_rule that does not list the
/// partitions denies too; <default> is DENY. Neither evaluates data tags.
Decision judge_as(Product product, const CompiledGrant& grant, DomainId domain, Action action,
                  const Request& request);

/// As judge_as, for endpoints of the process itself. Measured with Fast DDS 2.9.1: there, and only
/// there, it ignores the <domains> of a rule.
Decision judge_local_as(Product product, const CompiledGrant& grant, DomainId domain, Action action,
                        const Request& request);

/// Returns the validity as the product reads it (product_reading.hpp).
Validity validity_as(Product product, const Validity& validity);

/// Judges like CompiledGrant::judge_participant. Cyclone DDS and Fast DDS admit a participant by
/// any allow_rule for the domain, wherever it is; Fast DDS reads <default> as DENY.
Decision judge_participant_as(Product product, const CompiledGrant& grant, DomainId domain);

}  // namespace ddssec::governance::doctor
