#include "pki/participant_folder.hpp"

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

}  // namespace

bool may_exist(const fs::path& path) {
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  return type != fs::file_type::not_found && error != std::errc::filename_too_long;
}

bool may_be_changed_by_others(const fs::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return true;
  return !is_of_trusted_owner(status) || others_may_write(status);
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
