// participants.toml: the description of a fleet in one file.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/participant/participant.hpp"

namespace ddssec::cli {

/// The largest number of participants in one file.
inline constexpr std::size_t kMaxParticipants = 100'000;
/// The longest file, in octets.
inline constexpr std::size_t kMaxFleetOctets = 32 * 1024 * 1024;

/// Reads a fleet. The file has tables [[participant]] with name, subject, domain, days, key,
/// publish, subscribe, permissions (the path of a document, relative to the file's folder). The
/// same keys at the top, except name, subject and permissions, are defaults for all participants.
/// `standard` applies if neither is given; its validity is counted from `now`. An unknown key is an
/// error, because a misspelt right would otherwise be missing. Errors: fleet_malformed with the
/// line, name_unusable, those of read_file.
Result<std::vector<ParticipantSpec>> read_fleet(const std::filesystem::path& file,
                                                const ParticipantSpec& standard, WallTime now);

}  // namespace ddssec::cli
