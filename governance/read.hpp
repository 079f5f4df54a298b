// Reads governance and permissions documents: lenient in form, with precise errors.
#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// The largest number of domain rules and topic rules of a governance document together, and of
/// grants, rules, topics, partitions and tags of a permissions document together.
inline constexpr std::size_t kMaxEntries = 500'000;

/// Reads a governance document of DDS-Security 1.1 or 1.2. Accepts elements in any order, white
/// space around values, and booleans as true, false, 1, 0 or in capitals. Anything that other
/// products may read differently becomes a note. `xml` is the verified content, never the signed
/// file. `first_line` is the line of that file on which it begins, so that all line numbers refer
/// to the file. Errors: those of XmlDocument::parse, document_kind, element_*, attribute_unknown,
/// text_unexpected, value_*, domain_range_reversed, too_many_rules.
Result<Governance> read_governance(BytesView xml, int first_line = 1);

/// Reads a permissions document. Errors: as above, and validity_reversed, value_not_date_time,
/// value_not_default. A grant without <default> denies (DDS-Security 1.2, clause 10.4.1.5.3.4).
Result<Permissions> read_permissions(BytesView xml, int first_line = 1);

}  // namespace ddssec::governance
