// A CA and its successor side by side, while participants move from one to the other.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "pki/crl.hpp"

namespace ddssec::cli {

/// An overlap of two CAs. Both are in the CA's file, the successor first. A stock Cyclone DDS reads
/// only the first certificate of a CA file, so in a participant's file the CA of its own documents
/// comes first.
struct CaOverlap {
  std::vector<pki::Certificate> next;    ///< the successor, and the CAs above it
  std::vector<pki::Certificate> former;  ///< the certificates that only the former CA needs
  WallTime until;                        ///< the date on which the former CA should end

  std::string next_only() const { return to_pem(next); }
  /// Returns the file for a participant that has moved, which is also the CA's own file.
  std::string next_first() const { return to_pem(next) + to_pem(former); }
  /// Returns the file for a participant that has not moved.
  std::string former_first() const { return to_pem(former) + to_pem(next); }
};

/// Returns the overlap that begins with a successor. `former` is the former content of the CA's
/// file.
CaOverlap overlap_of(std::vector<pki::Certificate> next,
                     const std::vector<pki::Certificate>& former, WallTime until);

/// Returns the path of the file with the date and the former CA's fingerprints, beside the CA's
/// certificate.
std::filesystem::path overlap_file(const CaPaths& ca);
std::string overlap_text(const CaOverlap& overlap);

/// Reads the overlap that is under way. Empty if there is none or if the CA was replaced since.
/// Errors: those of read_certificates and read_file; overlap_unreadable.
Result<std::optional<CaOverlap>> read_overlap(const CaPaths& ca);

/// Returns the path of the file with the folders that the end of a rotation did not find, beside
/// the CA's certificate.
std::filesystem::path unreached_file(const CaPaths& ca);
std::string unreached_text(const std::vector<std::string>& folders);
/// Reads the folders in that file. Empty if the file cannot be read.
std::vector<std::string> read_unreached(const CaPaths& ca);

/// Reads the lists in the CA's file that its former key signed.
Result<std::vector<pki::Crl>> lists_of_former(const CaPaths& ca, const CaOverlap& overlap);
/// Returns the CA's file of lists with its next list. During an overlap it also keeps the lists of
/// the CA's former key.
Result<std::string> file_of_lists(const CaPaths& ca, const pki::Crl& next);

/// Success unless only the former CA of an overlap signed the document: the participant must then
/// first move with all its documents. Error: not_moved_yet.
Status check_moved(const CaPaths& ca, const std::filesystem::path& document, WallTime now);

/// As check_moved above, for a document that was verified already, with its signer.
Status check_moved(const CaPaths& ca, const pki::Certificate& signer,
                   const std::filesystem::path& document);

}  // namespace ddssec::cli
