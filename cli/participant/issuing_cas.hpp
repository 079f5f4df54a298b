// The CAs of a command that issues participants.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/command.hpp"
#include "cli/participant/participant.hpp"
#include "pki/crl.hpp"

namespace ddssec::cli {

/// The CAs that sign, and the revocation list for newcomers.
struct IssuingCas {
  OpenCa identity;
  std::optional<OpenCa> permissions;
  std::optional<pki::Crl> list;
  std::string crl;                ///< `list` in PEM
  std::string permissions_trust;  ///< as permissions_trust() returns it

  /// Returns the issuers for a participant with or without permissions.
  Issuers issuers(bool with_permissions) const {
    return {identity, with_permissions ? &*permissions : nullptr, crl, permissions_trust};
  }
};

/// Returns the certificates of the permissions CA below --ca, in PEM: a participant needs them,
/// also if its documents come later. No key is read. --ca may be the folder of one CA. It is taken
/// for the permissions CA only if it signs a document of the participant; otherwise the result is
/// empty.
Result<std::string> permissions_trust(const Arguments& arguments, bool signs_documents);

/// Opens the CAs below --ca; the permissions CA only `with_permissions`. Errors: those of
/// CaOpener::open and list_for_newcomers.
Result<IssuingCas> open_issuing_cas(const Arguments& arguments, bool with_permissions,
                                    WallTime now);

/// Makes the participant's certificate and documents, all within the life of its CA. `from` is the
/// file that an error in the permissions names. Errors: those of within_ca and make_participant.
Result<NewParticipant> make_participant_within_ca(ParticipantSpec& spec, const IssuingCas& cas,
                                                  const Arguments& arguments,
                                                  const Context& context,
                                                  const std::filesystem::path& from);

/// Writes the logs. Call it as the last step before files get their places, because a certificate
/// that the log lacks cannot be revoked.
Status log_participants(const IssuingCas& cas, std::string_view issued,
                        std::string_view signed_lines);
/// As log_participants, for one participant. Also returns the errors of SubjectsInUse::check.
Status log_participant(const IssuingCas& cas, const NewParticipant& made,
                       const std::filesystem::path& folder, WallTime now);

}  // namespace ddssec::cli
