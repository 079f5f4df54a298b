// The renewal list of a participant's folder, for doctor, check and keystore verify.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// DOC115, if the folder has a renewal list: one finding if it cannot be read, or if entries of it
/// have no effect, since they have ended, were revoked, or are of no CA of the folder. Whether an
/// entry extends what a peer presents is not looked at.
void check_renewal_list(const governance::doctor::LoadedFolder& folder,
                        const governance::doctor::Settings& settings,
                        governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
