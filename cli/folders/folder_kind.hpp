// Suggestions for a folder that does not exist or is of another kind.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::cli {

/// Success if `given` is a participant's folder, complete or not. Errors: file_not_found and
/// file_unreadable, which name participants nearby.
Status check_participant_folder(const std::filesystem::path& given);

/// Reads the certificate in a participant's folder or in a file. Errors: those of read_certificate,
/// which name participants nearby or report that the file contains a key.
Result<pki::Certificate> certificate_of(const std::filesystem::path& given);

/// Returns a text such as "participants here: demo/talker, demo/listener". Participants of the same
/// name come first. Empty if there are none.
std::string participants_near(const std::filesystem::path& missing);

/// Success unless `given` is the folder of a CA or of several participants: the files of another
/// participant, `name`, do not belong there. Error: would_overwrite.
Status check_not_above_participants(const std::filesystem::path& given, std::string_view name);

/// Success if `given` is a folder with the `role`'s CA ("identity", "permissions"). Errors:
/// file_not_found and file_unreadable, which name CAs nearby.
Status check_ca_folder(const std::filesystem::path& given, std::string_view role);
/// As check_ca_folder, for a CA that will sign. Also refuses the folder of the other one of two
/// CAs, because a signature by the wrong one is detected only when a participant starts. Errors: as
/// above, usage.
Status check_signing_ca(const std::filesystem::path& given, std::string_view role);

}  // namespace ddssec::cli
