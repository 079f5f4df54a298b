// participants.toml: a fleet in one file.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/participant.hpp"

namespace ddssec::cli {

/// The most participants of one file.
inline constexpr std::size_t kMostParticipants = 100'000;
/// The longest file, in octets.
inline constexpr std::size_t kMostFleetOctets = 32 * 1024 * 1024;

/// Reads a fleet: tables [[participant]] with name, subject, domain, days, key, publish, subscribe,
/// permissions (a document's path, from the file's folder), and the same but name, subject and
/// permissions at the top as what counts where a participant does not say. `standard` is what
/// counts where neither does; its validity begins and is measured from `now`. A key that is not
/// known is an error: a right misspelt would be a right not given. Errors: fleet_malformed with the
/// line, name_unusable, those of read_file.
Result<std::vector<ParticipantSpec>> read_fleet(const std::filesystem::path& file,
                                                const ParticipantSpec& standard, WallTime now);

}  // namespace ddssec::cli
