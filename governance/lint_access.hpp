// Checks which participants may join a domain, and read and write its topics, for lint. For
// governance/ only.
#pragma once

#include "governance/domain_place.hpp"
#include "governance/lint_findings.hpp"

namespace ddssec::governance {

/// True if neither submessages nor payloads of the topic are protected.
bool is_plain(const TopicRule& rule);
/// True if any kind of the domain or of its topics is SIGN or more.
bool protects_anything(const DomainRule& rule);

/// Checks GOV014: rules that take names from a later one that protects more.
void diagnose_overlaps(LintFindings& out, const DomainPlace& place);
/// Checks GOV021, GOV022, GOV025, GOV040, GOV041, GOV043, and GOV047 to GOV050.
void diagnose_access(LintFindings& out, const DomainPlace& place);

}  // namespace ddssec::governance
