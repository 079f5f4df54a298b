// Two permissions documents compared as sets of what they allow.
#pragma once

#include <string>
#include <vector>

#include "governance/compare/grant_diff.hpp"
#include "governance/compare/readings.hpp"
#include "governance/model.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

struct PermissionsDiff {
  /// neutral, narrower, wider, mixed or unknown.
  ChangeClass verdict = ChangeClass::neutral;
  /// Changed defaults first, then by class, the most worrying first.
  std::vector<PermissionChange> changes = {};
  /// False: some of the rules that changed in the same way as others are not named.
  bool is_complete = true;
  /// False: not every kind of endpoint or subject was tried; the verdict is unknown or mixed then.
  bool is_exact = true;
  /// What other products read differently.
  Readings readings = {};
};

struct PermissionsDiffOptions {
  /// A subject that only the old document has and one that only the new one has are the same
  /// participant if their grants have the same name and neither is an expression.
  bool map_subjects_by_grant_name = false;
  SetLimits limits = {};
};

/// Compares what every subject may do, in every domain with every tag and at every time; of a
/// subject's grants the first that is valid counts (see find_grant). To have a valid grant is a
/// right of its own: it opens what the governance document leaves open. Validities that do not meet
/// are compared as if they did: a renewal is not a new participant. A subject written in another
/// way is "interop": the same to us. Expressions written in another way are "rewritten".
PermissionsDiff compare(const Permissions& old_document, const Permissions& new_document,
                        const PermissionsDiffOptions& options = {});

}  // namespace ddssec::governance
