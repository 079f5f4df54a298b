// The paths of a participant's files, in either of the two layouts of folders.
#pragma once

#include <cstdint>
#include <filesystem>

namespace ddssec::pki {

/// The names of the files in a participant's folder.
enum class FolderLayout : std::uint8_t {
  flat,   ///< identity_ca.pem, permissions_ca.pem
  sros2,  ///< identity_ca.cert.pem, permissions_ca.cert.pem: an enclave of a ROS 2 keystore
};

/// The paths of a participant's files; none of the files needs to exist. Keys and certificates end
/// in .pem. If only a file of the same name in .p11 exists, the path is that file, which names the
/// object in a token (see uri_of).
struct ParticipantFolder {
  FolderLayout layout;
  std::filesystem::path folder;
  std::filesystem::path identity_ca;
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path permissions_ca;
  std::filesystem::path governance;
  std::filesystem::path permissions;
  std::filesystem::path crl;         ///< optional in both layouts
  std::filesystem::path renewals;    ///< renewed.pem, a pki::RenewalList; optional in both layouts
  std::filesystem::path properties;  ///< security.properties; optional, used by ddssec only
};

/// False if no file of that name can exist. True in all other cases, also for a dangling link and
/// for a file in a folder that cannot be searched. Such a document must not count as absent, and
/// reading it reports what is wrong.
bool may_exist(const std::filesystem::path& path);

/// True if a user other than root and the process's own can change a file of the participant, or
/// put another one in its place: the folder or one of its files (or what a link leads to) belongs
/// to another user, its group or everyone may write to it, or the same goes for a folder above.
/// True also if that cannot be found out.
bool may_be_changed_by_others(const ParticipantFolder& paths);

/// True if the folder looks like one of a participant: it has a certificate or an identity CA. It
/// serves to choose hints and sentences, so it is false for a folder that cannot be searched,
/// unlike may_exist.
bool is_participant_folder(const std::filesystem::path& folder);

/// True if the folder looks like one of a CA, as `ca create` and `init` make it: it has a CA's
/// certificate or key, or the certificate of an identity CA in identity/. False for a folder that
/// cannot be searched.
bool is_ca_folder(const std::filesystem::path& folder);

/// Returns the path of a key or certificate: `file`, or the *.p11 file in its place that names the
/// object in a token, if only that one exists.
std::filesystem::path path_or_token_file(const std::filesystem::path& file);

/// Returns the paths of `folder` in a layout.
ParticipantFolder participant_folder(const std::filesystem::path& folder, FolderLayout layout);

/// Returns the paths of `folder` in its layout: sros2 if one of the CA files exists under its sros2
/// name and not under its flat name, otherwise flat. A symbolic link counts as existing even if it
/// is dangling.
ParticipantFolder participant_folder(const std::filesystem::path& folder);

}  // namespace ddssec::pki
