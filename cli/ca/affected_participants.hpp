// The participants whose files change when a CA is rotated.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca/ca_rotation.hpp"

namespace ddssec::cli {

/// The participants that change with the CA, and those in the log that cannot be found.
struct AffectedParticipants {
  std::vector<AffectedParticipant> here;
  std::vector<std::string> elsewhere;  ///< folders, or subjects of CAs below
  /// The places in `elsewhere` that the log has on this machine, and whose folder no longer exists.
  std::vector<std::string> gone = {};
};

/// Returns the participant of a folder, named by its path.
AffectedParticipant participant_in(const std::filesystem::path& folder);

/// Returns all participants in the log of the identity CA; none if it has no log. `given` is a
/// folder as for ca_paths(). Errors: those of read_issue_log and read_certificate.
Result<AffectedParticipants> affected_participants(const std::filesystem::path& given,
                                                   WallTime now);

/// Records new places in the identity CA's log: for each folder that the command line names, if the
/// log has its certificate for another folder in which it no longer lies. (A permissions CA issues
/// no certificate that would update the log.) `updated` has the names of participants that get new
/// files. The caller holds the identity CA's lock. Errors: those of read_issue_log and log_issued.
Status log_places(const std::filesystem::path& given,
                  const std::vector<AffectedParticipant>& participants,
                  const std::vector<std::string>& updated, WallTime now);

}  // namespace ddssec::cli
