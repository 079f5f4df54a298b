// The subjects that grants of two documents tell apart, and the grants of each.
#pragma once

#include <string>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

using Grants = std::vector<const Grant*>;

/// Subjects for which both documents have the same grants, in document order.
struct Subject {
  Grants old_grants = {}, new_grants = {};
};

struct Subjects {
  std::vector<Subject> all = {};
  /// False: there are more combinations of expressions than can be tried, or expressions with
  /// several attributes of one type in one RDN.
  bool is_exact = true;
};

/// Every subject that some grant is for (see is_for) is of exactly one entry, in the order of the
/// grants of the old document, then of the new one. Subjects that no grant is for are left out.
Subjects subjects_of(const Permissions& old_document, const Permissions& new_document);

/// The subject as the grants write it, the plainest spelling.
const Grant& spelling_of(const Subject& subject);

/// True if both are for just the same subjects, however they are written. False if that could not
/// be found out.
bool same_subjects(const Grant& a, const Grant& b);

}  // namespace ddssec::governance
