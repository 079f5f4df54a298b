// The participants whose files change with a CA that is rotated.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca_rotation.hpp"

namespace ddssec::cli {

/// The participants that change with the CA, and those in the log that cannot be found.
struct KnownFollowers {
  std::vector<Follower> here;
  std::vector<std::string> elsewhere;  ///< folders, or subjects of CAs below
  /// Those in `elsewhere` whose folder was on this machine by the log, and is not there any more.
  std::vector<std::string> gone = {};
};

/// The participant of a folder, named by its path.
Follower follower_in(const std::filesystem::path& folder);

/// All that the log of the identity CA has; none if it has no log. `given` is a folder as for
/// ca_paths(). Errors: those of read_issue_log and read_certificate.
Result<KnownFollowers> known_followers(const std::filesystem::path& given, WallTime now);

}  // namespace ddssec::cli
