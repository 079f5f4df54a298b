// Checks the renewal list of a participant's folder, for doctor, check and keystore verify.
#pragma once

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::cli {

/// Reports DOC115 if the folder has a renewal list that cannot be read, or that has entries without
/// effect: they have expired, were revoked, or are of no CA of the folder. It does not check
/// whether an entry extends what a peer presents.
void diagnose_renewal_list(const governance::doctor::LoadedFolder& folder,
                           const governance::doctor::Settings& settings,
                           governance::doctor::Diagnosis& out);

}  // namespace ddssec::cli
