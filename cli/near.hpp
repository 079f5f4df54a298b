// What a person may have meant by a folder that is not there, or is of another kind.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::cli {

/// Success if `given` is a participant's folder, complete or not. Errors: file_not_found,
/// file_unreadable, which name participants nearby.
Status check_participant_folder(const std::filesystem::path& given);

/// The certificate of a participant's folder, or in a file. Errors: those of read_certificate; they
/// name participants nearby, or say that the file holds a key.
Result<pki::Certificate> certificate_of(const std::filesystem::path& given);

/// "participants here: demo/talker, demo/listener", those of the same name first; empty without
/// any.
std::string participants_near(const std::filesystem::path& missing);

/// What may be wrong with the path of a file that is not there: its folder is missing, or the name
/// is close to that of another file. Empty if neither.
std::string about_missing(const std::filesystem::path& missing);

/// Success unless `given` is the folder of a CA or of participants, where the files of one more
/// participant, `name`, do not belong. Error: would_overwrite.
Status check_not_above_participants(const std::filesystem::path& given, std::string_view name);

/// Success if `given` is a folder with the `role`'s CA ("identity", "permissions"). Errors:
/// file_not_found and file_unreadable, which name CAs nearby.
Status check_ca_folder(const std::filesystem::path& given, std::string_view role);
/// The same where the CA is to sign: the folder of the other one of two CAs is refused as well,
/// since a signature by the wrong one is found out only when a participant starts. Error: usage.
Status check_signing_ca(const std::filesystem::path& given, std::string_view role);

}  // namespace ddssec::cli
