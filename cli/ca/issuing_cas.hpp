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
  std::string crl;  ///< the same, in PEM

  /// For a participant with permissions, or without.
  Issuers issuers(bool with_permissions) const {
    return {identity, with_permissions ? &*permissions : nullptr, crl};
  }
};

/// The CAs below --ca; the permissions CA only `with_permissions`. Errors: those of CaOpener::open
/// and list_for_newcomers.
Result<IssuingCas> open_issuing_cas(const Arguments& arguments, bool with_permissions,
                                    WallTime now);

/// Makes what the participant gets, within the life of its CA. `from`: the file that an error in
/// the permissions is about. Errors: those of within_ca and make_participant.
Result<NewParticipant> make(ParticipantSpec& spec, const IssuingCas& cas,
                            const Arguments& arguments, const Context& context,
                            const std::filesystem::path& from);

/// The last step before files get their places: a certificate that the log lacks cannot be revoked.
Status log_all(const IssuingCas& cas, std::string_view issued, std::string_view signed_lines);
/// The same for one participant. Errors also: those of SubjectsInUse::check.
Status log_one(const IssuingCas& cas, const NewParticipant& made,
               const std::filesystem::path& folder, WallTime now);

}  // namespace ddssec::cli
