// Reads governance and permissions documents: lenient in form, precise in errors.
#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// The most domain rules and topic rules of a governance document together, and the most grants,
/// rules, topics, partitions and tags of a permissions document together.
inline constexpr std::size_t kMostEntries = 500'000;

/// Reads a governance document, 1.1 complete and the elements of 1.2. Elements in any order, white
/// space around values, booleans as true, false, 1, 0 or in capitals; what other products may read
/// differently becomes a note. `xml` is the verified content, never the signed file; `first_line`
/// is the line of that file on which it begins, so that all lines that are told are the file's.
/// Errors: those of XmlDocument::parse, document_kind, element_*, attribute_unknown,
/// text_unexpected, value_*, domain_range_reversed, too_many_rules.
Result<Governance> read_governance(BytesView xml, int first_line = 1);

/// Reads a permissions document. As above, and validity_reversed, value_not_date_time,
/// value_not_default. A grant without <default> denies (DDS-Security 1.2 9.4.1.3.2.3).
Result<Permissions> read_permissions(BytesView xml, int first_line = 1);

}  // namespace ddssec::governance
