#include "pki/participant_folder.hpp"

#include <algorithm>
#include <array>
#include <sys/stat.h>
#include <system_error>

#include "base/folder_rights.hpp"

namespace ddssec::pki {
namespace fs = std::filesystem;
namespace {

bool is_seen(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(fs::symlink_status(path, ignored));
}

// True also if that cannot be found out.
bool is_open(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return true;
  return !is_of_trusted_owner(status) || others_may_write(status);
}

std::array<const fs::path*, 9> files_of(const ParticipantFolder& paths) {
  return {&paths.identity_ca, &paths.certificate, &paths.key, &paths.permissions_ca,
          &paths.governance,  &paths.permissions, &paths.crl, &paths.renewals,
          &paths.properties};
}

}  // namespace

bool may_exist(const fs::path& path) {
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  return type != fs::file_type::not_found && error != std::errc::filename_too_long;
}

bool may_be_changed_by_others(const ParticipantFolder& paths) {
  std::error_code error;
  const auto folder = fs::canonical(paths.folder, error);
  if (error || is_open(folder) || open_folder_above(folder.parent_path())) return true;
  return std::ranges::any_of(files_of(paths), [](const fs::path* file) {
    if (!may_exist(*file)) return false;
    std::error_code failed;
    const auto target = fs::canonical(*file, failed);
    return failed || is_open(target) || open_folder_above(target.parent_path());
  });
}

bool is_participant_folder(const fs::path& folder) {
  const auto files = participant_folder(folder);
  return is_seen(files.certificate) || is_seen(files.identity_ca);
}

bool is_ca_folder(const fs::path& folder) {
  return is_seen(folder / "ca.pem") || is_seen(folder / "ca.key.pem") ||
         is_seen(folder / "identity/ca.pem");
}

fs::path path_or_token_file(const fs::path& file) {
  auto in_token = fs::path(file).replace_extension(".p11");
  return may_exist(in_token) && !may_exist(file) ? in_token : file;
}

ParticipantFolder participant_folder(const fs::path& folder, FolderLayout layout) {
  const bool flat = layout == FolderLayout::flat;
  return {.layout = layout,
          .folder = folder,
          .identity_ca =
              path_or_token_file(folder / (flat ? "identity_ca.pem" : "identity_ca.cert.pem")),
          .certificate = path_or_token_file(folder / "cert.pem"),
          .key = path_or_token_file(folder / "key.pem"),
          .permissions_ca = path_or_token_file(
              folder / (flat ? "permissions_ca.pem" : "permissions_ca.cert.pem")),
          .governance = folder / "governance.p7s",
          .permissions = folder / "permissions.p7s",
          .crl = folder / "crl.pem",
          .renewals = folder / "renewed.pem",
          .properties = folder / "security.properties"};
}

ParticipantFolder participant_folder(const fs::path& folder) {
  auto flat = participant_folder(folder, FolderLayout::flat);
  auto sros2 = participant_folder(folder, FolderLayout::sros2);
  const bool is_sros2 = (may_exist(sros2.identity_ca) && !may_exist(flat.identity_ca)) ||
                        (may_exist(sros2.permissions_ca) && !may_exist(flat.permissions_ca));
  return is_sros2 ? sros2 : flat;
}

}  // namespace ddssec::pki
