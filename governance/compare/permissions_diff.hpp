// Compares two permissions documents by what they allow.
#pragma once

#include <vector>

#include "governance/compare/grant_diff.hpp"
#include "governance/compare/interpretations.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// The changes from one permissions document to another.
struct PermissionsDiff {
  /// neutral, narrower, wider, mixed or unknown.
  ChangeClass verdict = ChangeClass::neutral;
  /// Changed defaults first, then by class, the most serious first.
  std::vector<PermissionChange> changes = {};
  /// False if some rules that changed in the same way as others are not listed.
  bool is_complete = true;
  /// False if not every kind of endpoint or subject was tried; the verdict is unknown or mixed
  /// then.
  bool is_exact = true;
  /// Constructs that other products read differently.
  Interpretations interpretations = {};
};

/// How subjects and rules are compared, and how much work the comparison may take.
struct PermissionsDiffOptions {
  /// True if a subject that only the old document has and one that only the new document has count
  /// as the same participant, provided that their grants have the same name and neither is an
  /// expression.
  bool map_subjects_by_grant_name = false;
  /// True to decide as Cyclone DDS 0.10 does; see compare_grants.
  bool first_rule_creates_topic = false;
  SetLimits limits = {};
};

/// Compares the permissions of every subject, in every domain with every tag and at every time. Of
/// a subject's grants, the first valid one counts (see find_grant). Having a valid grant is a right
/// of its own, because it gives access to everything that the governance document leaves open.
///
/// Validities that do not overlap are compared as if they did, because a renewal is not a new
/// participant. A subject that is written differently is "interop": the same for ddssec.
/// Expressions that are written differently are "rewritten".
PermissionsDiff compare(const Permissions& old_document, const Permissions& new_document,
                        const PermissionsDiffOptions& options = {});

}  // namespace ddssec::governance
