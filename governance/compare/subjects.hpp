// Finds the subjects that the grants of two documents distinguish, with the grants of each.
#pragma once

#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

using Grants = std::vector<const Grant*>;

/// A set of subjects with the same grants in both documents, in document order.
struct Subject {
  Grants old_grants = {}, new_grants = {};
};

/// Examples of all kinds of subjects that the documents can distinguish.
struct Subjects {
  std::vector<Subject> all = {};
  /// False if there are more combinations of expressions than can be tried, or expressions with
  /// several attributes of one type in one RDN.
  bool is_exact = true;
};

/// Finds the sets. Every subject that has a grant (see is_for) is in exactly one of them. They are
/// in the order of the grants of the old document, then of the new one. Subjects without a grant
/// are left out.
Subjects subjects_of(const Permissions& old_document, const Permissions& new_document);

/// Returns the grant with the plainest spelling of the subject.
const Grant& spelling_of(const Subject& subject);

/// True if both are for exactly the same subjects, in any spelling. False if that could not be
/// determined.
bool same_subjects(const Grant& a, const Grant& b);

}  // namespace ddssec::governance
