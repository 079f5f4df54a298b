// The paths of a CA's files.
#pragma once

#include <filesystem>
#include <string_view>

namespace ddssec::cli {

/// The paths of a CA's files.
struct CaPaths {
  /// The current certificate comes first, then others that the CA needs.
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path log;  ///< pki::IssueLog
  std::filesystem::path crl;
  std::filesystem::path signed_log;  ///< pki::SigningLog, of a permissions CA
  std::filesystem::path renewals;    ///< pki::RenewalList
};

/// The files of a CA below its folder (ca.pem, ca.key.pem, issued.jsonl, crl.pem,
/// signed.jsonl).
CaPaths ca_paths_in(const std::filesystem::path& folder);

/// The files of the CA with that role ("identity", "permissions"). `given` is the result of `ca
/// create`, `init` or `keystore create`, or a folder with ca.pem.
CaPaths ca_paths(const std::filesystem::path& given, std::string_view role);

/// The certificate of a CA; `given` is the certificate, or anything that ca_paths() accepts.
std::filesystem::path ca_certificate_path(const std::filesystem::path& given,
                                          std::string_view role);

}  // namespace ddssec::cli
