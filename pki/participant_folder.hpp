// Where a participant's files lie, in either of the two layouts that folders have.
#pragma once

#include <cstdint>
#include <filesystem>

namespace ddssec::pki {

/// How the files of a participant's folder are called.
enum class FolderLayout : std::uint8_t {
  flat,   ///< identity_ca.pem, permissions_ca.pem
  sros2,  ///< identity_ca.cert.pem, permissions_ca.cert.pem: an enclave of a ROS 2 keystore
};

/// The paths of a participant's files. They are where the files would be: none of them must exist.
/// Keys and certificates end in .pem, or in .p11 where there is only a file of that name, which
/// says in which token they are (see uri_of).
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
  std::filesystem::path properties;  ///< security.properties; optional, and ours alone
};

/// `file`, a key or certificate; or, where there is none, the *.p11 in its place that says in which
/// token it is.
std::filesystem::path or_in_token(const std::filesystem::path& file);

/// The paths of `folder` in a layout.
ParticipantFolder participant_folder(const std::filesystem::path& folder, FolderLayout layout);

/// The paths of `folder` in the layout that it has: sros2 if one of the CA files has its sros2 name
/// and the same one not its flat name, else flat. Symbolic links count as they stand.
ParticipantFolder participant_folder(const std::filesystem::path& folder);

}  // namespace ddssec::pki
