// The identity CA's own revocation list, where the CA lies beside the participant: the keystore of
// an enclave, or the CA's folder that `init` and `ca create` make.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::governance::doctor {

struct CaList {
  pki::Crl list;
  std::filesystem::path file;
};

/// The newest list that lies in a CA's place beside the folder or above it and that one of `cas`
/// signed, whatever its dates, if its number is higher than those of `own`, the participant's.
std::optional<CaList> newer_ca_list(const pki::ParticipantFolder& folder,
                                    const std::vector<pki::Certificate>& cas,
                                    const std::vector<pki::Crl>& own);

/// The newest list in such a place of a CA that signed a list of `own` with a higher number: the
/// CA's folder came back from a backup, or it is a copy.
std::optional<CaList> outdated_ca_list(const pki::ParticipantFolder& folder,
                                       const std::vector<pki::Certificate>& cas,
                                       const std::vector<pki::Crl>& own);

/// True if the list has the certificate's issuer and serial number.
bool names(const pki::Crl& list, const pki::Certificate& certificate);

}  // namespace ddssec::governance::doctor
