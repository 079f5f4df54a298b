// The ends of a CA's overlaps (ca rotate --overlap). The agent ends each overlap at its date.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// An overlap that the agent ends, of a CA of --ca.
struct OverlapToEnd {
  std::string role;
  WallTime until;
  /// The reason why its record cannot be read. The overlap is then due now, so that the agent
  /// reports it: otherwise the former CA would be trusted for ever.
  std::optional<Error> fault = {};
};
/// Returns the overlaps that are under way: of the identity CA and, with --permissions, of the
/// permissions CA.
std::vector<OverlapToEnd> overlaps_to_end(const Arguments& agent);

/// Runs `ca rotate --end --when-due` for that role. Every folder that the CA's log knows here must
/// belong to this user, since the command writes them with this user's rights. The result has
/// members of an event:
///   {"role", "subject", "until", "folders", "left", "files", "problem"}
/// "left": the folders that still have their former files; "problem": the first error about them.
/// Errors: `fault`; folder_untrusted; those of the command.
Result<Json> end_overlap(const OverlapToEnd& overlap, const Arguments& agent,
                         const Context& context);

}  // namespace ddssec::cli
