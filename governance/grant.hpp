// Finds the grant of a subject in a permissions document.
#pragma once

#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {

/// The first grant for `subject` whose validity contains `now`; grants outside their validity are
/// ignored (DDS-Security 1.2 9.4.1.3.2.2). Names compare by SubjectName::matches, expressions RDN by
/// RDN in the same way. `shown` is how errors name the subject.
/// Errors: no_grant_for_subject; grant_expired or grant_not_yet_valid if there are only such.
Result<const Grant*> find_grant(const Permissions& permissions, const pki::SubjectName& subject,
                                std::string_view shown, WallTime now);

/// True if the grant is for the subject, whatever its validity.
bool is_for(const Grant& grant, const pki::SubjectName& subject);

/// Success while the grant is valid, else grant_expired or grant_not_yet_valid.
Status check_validity(const Grant& grant, WallTime now);

}  // namespace ddssec::governance
