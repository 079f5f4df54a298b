// Reads and writes governance and permissions documents for commands.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/command.hpp"
#include "governance/model.hpp"
#include "governance/profile.hpp"
#include "governance/read.hpp"
#include "pki/participant_folder.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {

/// Reads the signed document and verifies it at `now` with the permissions CA file `ca`. Errors:
/// those of read_file, of Certificate::bundle_from_pem (with the name of `ca`), and of the
/// verification (with the name of `file`).
Result<pki::SignedDocument> verified(const std::filesystem::path& file,
                                     const std::filesystem::path& ca, WallTime now);

/// The XML of a document, plain or signed, and the line of its file on which it begins.
struct DocumentText {
  Bytes xml;
  int first_line = 1;
};
/// Reads the text of a document, NOT verified: only to be displayed and linted. Errors: those of
/// read_file; smime_malformed if a signed form contains no text.
Result<DocumentText> unverified_text(const std::filesystem::path& file);

/// A kind of document, for commands that work on both kinds.
struct GovernanceKind {
  using Document = governance::Governance;
  static constexpr auto kInFolder = &pki::ParticipantFolder::governance;
  static Result<Document> read(BytesView xml, int first_line = 1) {
    return governance::read_governance(xml, first_line);
  }
};
/// The traits of a permissions document, for code that handles both kinds.
struct PermissionsKind {
  using Document = governance::Permissions;
  static constexpr auto kInFolder = &pki::ParticipantFolder::permissions;
  static Result<Document> read(BytesView xml, int first_line = 1) {
    return governance::read_permissions(xml, first_line);
  }
};

/// Returns the path of the document in a participant's folder, or `given` itself if it is not a
/// folder.
template <class Kind>
std::filesystem::path document_path(const std::filesystem::path& given) {
  std::error_code ignored;
  return std::filesystem::is_directory(given, ignored)
             ? pki::participant_folder(given).*Kind::kInFolder
             : given;
}

/// Reads the document in a file, plain or signed, NOT verified. Errors: those of unverified_text,
/// read_governance and read_permissions.
template <class Kind>
Result<typename Kind::Document> unverified_document(const std::filesystem::path& file) {
  auto text = unverified_text(file);
  if (!text) return std::unexpected(text.error());
  return with_default_document(Kind::read(text->xml, text->first_line), file);
}

/// Returns the length of the signed form of a document. `octets` are the document, plain or signed.
/// For a plain document the signature itself, of 1 to 4 KiB, is not counted.
std::size_t signed_size(BytesView octets);

/// Adds findings about this file to the report. The answer becomes "no" if one of them is an error.
void add_findings(Report& report, std::vector<Finding> findings, const std::filesystem::path& file);
/// The numbers of findings.
struct FindingCounts {
  std::size_t errors = 0, warnings = 0, notes = 0;

  static FindingCounts of(const std::vector<Finding>& findings);
  static constexpr auto fields() {
    return std::tuple(
        field<&FindingCounts::errors>(), field<&FindingCounts::warnings>(),
        field<&FindingCounts::notes>({"how many; the findings are in `diagnostics`"}));
  }
  /// Returns a text such as "2 errors, 1 warning, 3 notes"; "nothing found" if there are none.
  std::string words() const;
};

/// Returns FindingCounts::words() of these findings.
std::string counts_text(const std::vector<Finding>& findings);

/// Returns the value of --profile. Error: usage.
Result<governance::Profile> profile_option(const Arguments& arguments);

/// Returns the value of --domain, which has a default. Error: usage.
Result<DomainId> domain_of(const Arguments& arguments);
/// Returns the value of --domain, if given. Error: usage.
Result<std::optional<DomainId>> domain_option(const Arguments& arguments);

/// Returns the values of the option, each "3" or "0-5". Error: usage.
Result<std::vector<governance::DomainRange>> domain_ranges(const Arguments& arguments,
                                                           std::string_view option);

/// Returns the topics of a repeated option. Error: usage for a value with a comma, which would be
/// the name of one topic that does not exist.
Result<std::vector<std::string>> topics_of(const Arguments& arguments, std::string_view option);

/// Returns the path of the signed form beside a document: its path with the ending p7s.
std::filesystem::path signed_path(const std::filesystem::path& document);

/// Success if write_result() can use its target. Call it before writing a log, so that no log
/// contains a document that was never written. Error: would_overwrite.
Status check_result_place(const std::filesystem::path& target, const Arguments& arguments);
/// Writes a document for a command that has --replace. Errors: those of write_new_file and, with
/// that option, of FileTransaction.
Result<WrittenFile> write_result(const std::filesystem::path& target, BytesView octets,
                                 const Arguments& arguments);

}  // namespace ddssec::cli
