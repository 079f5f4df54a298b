// What a product decides by a grant, where it differs from the standard.
#pragma once

#include <string_view>
#include <vector>

#include "governance/decision.hpp"
#include "governance/doctor/vendor.hpp"

namespace ddssec::governance::doctor {

/// Whether `vendor` matches a name with an expression: each reads bracket expressions and
/// backslashes in a way of its own (dialect.hpp), and Fast DDS the blanks around them.
bool matches_as(Vendor vendor, const Text& expression, std::string_view name);

/// The first of the list that names the topic as `vendor` reads it, or nullptr.
const Criteria* naming(Vendor vendor, const std::vector<Criteria>& list, std::string_view topic);

/// The domain_rule that `vendor` applies in the domain; null if there is none.
const DomainRule* domain_rule_as(Vendor vendor, const Governance& governance, DomainId domain);

/// The first topic_rule for the topic as `vendor` reads them; null if there is none.
const TopicRule* topic_rule_as(Vendor vendor, const DomainRule& domain, std::string_view topic);

/// The rule by which Cyclone DDS 0.10 decides whether a topic may be created at all: the first for
/// the domain that names it in whatever direction. Null if none does.
const governance::Rule* first_rule_naming(const Grant& grant, DomainId domain,
                                          std::string_view topic);

/// As CompiledGrant::judge, but as `vendor` decides in `domain`, by expressions as it reads them.
/// Cyclone DDS takes a
/// deny_rule without partitions for the partition "" only. With Fast DDS the first rule whose
/// topic matches decides whatever its partitions are: a deny_rule denies in all of them, an
/// allow_rule that does not list the partitions denies too; and <default> is DENY. Neither looks at
/// data tags.
Verdict judge_as(Vendor vendor, const CompiledGrant& grant, DomainId domain, Action action,
                 const Request& request);

/// As CompiledGrant::judge_participant. Cyclone DDS and Fast DDS let a participant
/// join by any allow_rule for the domain, wherever it stands; Fast DDS takes <default> as DENY.
Verdict judge_participant_as(Vendor vendor, const CompiledGrant& grant, DomainId domain);

}  // namespace ddssec::governance::doctor
