// Finds the identity CA's own revocation list if the CA is near the participant's folder: in the
// keystore of an enclave, or in the CA's folder that `init` and `ca create` make.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::governance::doctor {

/// A revocation list that a CA's folder has, and the file that it is from.
struct CaList {
  pki::Crl list;
  std::filesystem::path file;
};

/// Returns the newest list, signed by one of `cas`, in a CA folder beside or above the
/// participant's folder, whatever its dates. Empty unless its number is higher than those of `own`,
/// the participant's lists.
std::optional<CaList> newer_ca_list(const pki::ParticipantFolder& folder,
                                    const std::vector<pki::Certificate>& cas,
                                    const std::vector<pki::Crl>& own);

/// Returns the newest list in such a folder whose CA signed a list of `own` with a higher number:
/// the CA's folder was restored from a backup, or is a copy.
std::optional<CaList> outdated_ca_list(const pki::ParticipantFolder& folder,
                                       const std::vector<pki::Certificate>& cas,
                                       const std::vector<pki::Crl>& own);

/// True if the list has the certificate's issuer and serial number. During the overlap of two CAs
/// of one name that does not suffice: see is_of_its_ca().
bool lists_certificate(const pki::Crl& list, const pki::Certificate& certificate);
/// True if one of `cas` signed the list and issued the certificate.
bool is_of_its_ca(const pki::Crl& list, const pki::Certificate& certificate,
                  const std::vector<pki::Certificate>& cas);

}  // namespace ddssec::governance::doctor
