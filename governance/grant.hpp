// Finds the grant of a subject in a permissions document.
#pragma once

#include <span>
#include <string_view>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {

/// Returns the first grant for `subject` whose validity contains `now`; other grants are ignored
/// (DDS-Security 1.2, clause 10.4.1.5.3.2). Names are compared with SubjectName::matches, and
/// expressions RDN by RDN in the same way. `shown` names the subject in errors. Errors:
/// no_grant_for_subject; grant_expired or grant_not_yet_valid if all grants for the subject are.
Result<const Grant*> find_grant(const Permissions& permissions, const pki::SubjectName& subject,
                                std::string_view shown, WallTime now);

/// True if the grant is for the subject, whatever its validity.
bool is_for(const Grant& grant, const pki::SubjectName& subject);

/// Returns the first of `grants` that is valid at `time`, or nullptr.
const Grant* valid_at(std::span<const Grant* const> grants, WallTime time);

/// Success while the grant is valid. Errors: grant_expired, grant_not_yet_valid.
Status check_validity(const Grant& grant, WallTime now);

}  // namespace ddssec::governance
