#include "cli/folders/ca_paths.hpp"

#include <string>

#include "cli/inputs/files.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Returns folder/identity or folder/permissions, or `folder` itself if it contains ca.pem.
fs::path ca_folder(const fs::path& folder, std::string_view role) {
  std::error_code ignored;
  return fs::exists(folder / "ca.pem", ignored) ? folder : folder / role;
}

}  // namespace

CaPaths ca_paths_in(const fs::path& folder) {
  return {folder / "ca.pem",       pki::path_or_token_file(folder / "ca.key.pem"),
          folder / "issued.jsonl", folder / "crl.pem",
          folder / "signed.jsonl", folder / "renewed.pem"};
}

CaPaths ca_paths(const fs::path& given, std::string_view role) {
  const std::string name = std::string(role) + "_ca";
  if (path_exists(given / "public" / (name + ".cert.pem")))  // the layout of a ROS 2 keystore
    return {
        given / "public" / (name + ".cert.pem"),      given / "private" / (name + ".key.pem"),
        given / "private" / (name + ".issued.jsonl"), given / "public" / (name + ".crl.pem"),
        given / "private" / (name + ".signed.jsonl"), given / "public" / (name + ".renewed.pem")};
  // `init` puts the CAs into a folder below its result.
  const auto inner = given / "ca";
  const bool from_init =
      !path_exists(given / role / "ca.pem") && path_exists(inner / role / "ca.pem");
  return ca_paths_in(ca_folder(from_init ? inner : given, role));
}

fs::path ca_certificate_path(const fs::path& given, std::string_view role) {
  std::error_code ignored;
  return fs::is_directory(given, ignored) ? ca_paths(given, role).certificate : given;
}

}  // namespace ddssec::cli
