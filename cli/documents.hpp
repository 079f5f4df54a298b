// Governance and permissions documents as commands read and write them.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "cli/command.hpp"
#include "governance/model.hpp"
#include "governance/profile.hpp"
#include "governance/read.hpp"
#include "pki/participant_folder.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {

/// The result; an error gets the path as its document if it had none.
template <class T>
Result<T> named(Result<T> result, const std::filesystem::path& path) {
  if (result) return result;
  return std::unexpected(result.error().in(path));
}

/// The signed document, verified at `now` against the permissions CA file `ca`.
/// Errors: those of read_file, Certificate::bundle_from_pem and DocumentVerifier::verify.
Result<pki::SignedDocument> verified(const std::filesystem::path& file,
                                     const std::filesystem::path& ca, WallTime now);

/// The XML of a document, plain or signed, and the line of its file on which it begins.
struct DocumentText {
  Bytes xml;
  int first_line = 1;
};
/// NOT verified: to be shown and linted, never obeyed.
/// Errors: those of read_file; smime_malformed if nothing can be found in a signed form.
Result<DocumentText> unverified_text(const std::filesystem::path& file);

/// A kind of document, for commands that do the same to both.
struct GovernanceKind {
  using Document = governance::Governance;
  static constexpr auto kInFolder = &pki::ParticipantFolder::governance;
  static Result<Document> read(BytesView xml, int first_line = 1) {
    return governance::read_governance(xml, first_line);
  }
};
struct PermissionsKind {
  using Document = governance::Permissions;
  static constexpr auto kInFolder = &pki::ParticipantFolder::permissions;
  static Result<Document> read(BytesView xml, int first_line = 1) {
    return governance::read_permissions(xml, first_line);
  }
};

/// The document of a participant's folder; `given` itself if it is none.
template <class Kind>
std::filesystem::path document_path(const std::filesystem::path& given) {
  std::error_code ignored;
  return std::filesystem::is_directory(given, ignored)
             ? pki::participant_folder(given).*Kind::kInFolder
             : given;
}

/// The document in a file, plain or signed, NOT verified. Errors: those of unverified_text,
/// read_governance and read_permissions.
template <class Kind>
Result<typename Kind::Document> unverified_document(const std::filesystem::path& file) {
  auto text = unverified_text(file);
  if (!text) return std::unexpected(text.error());
  return named(Kind::read(text->xml, text->first_line), file);
}

/// How long the signed form of a document is, which `octets` are, plain or signed. Of a plain one
/// without the signature itself, which has 1 to 4 KiB.
std::size_t signed_size(BytesView octets);

/// Findings about this file go into the report; the answer is "no" if one is an error.
void add_findings(Report& report, std::vector<Finding> findings, const std::filesystem::path& file);
/// "2 errors, 1 warning, 3 notes"; "nothing found" if there are none.
std::string counted(const std::vector<Finding>& findings);
/// errors, warnings, notes: how many.
Json counts_json(const std::vector<Finding>& findings);

/// What --profile says. Error: usage.
Result<governance::Profile> profile_option(const Arguments& arguments);

/// What --domain, which has a fallback, says. Error: usage.
Result<DomainId> domain_of(const Arguments& arguments);
/// What --domain says, or nothing. Error: usage.
Result<std::optional<DomainId>> domain_option(const Arguments& arguments);

/// What the option says, "3" or "0-5" each. Error: usage.
Result<std::vector<governance::DomainRange>> domain_ranges(const Arguments& arguments,
                                                           std::string_view option);

/// The topics of a repeated option. Error: usage, for two with a comma between them, which would be
/// the name of one topic that does not exist.
Result<std::vector<std::string>> topics_of(const Arguments& arguments, std::string_view option);

/// The signature that stands beside a document: its path with the ending p7s.
std::filesystem::path signed_path(const std::filesystem::path& document);

/// Success if write_result() finds its place free, so that no log names a document that was never
/// written. Error: would_overwrite.
Status check_result_place(const std::filesystem::path& target, const Arguments& arguments);
/// One document of a command that has --replace. Errors: those of write_new_file and, with that
/// option, of Replacement.
Result<WrittenFile> write_result(const std::filesystem::path& target, BytesView octets,
                                 const Arguments& arguments);

/// Writes a new document to what -o says and, with --sign, its signed form beside it (-o may name
/// either). Both or neither. Errors: usage (--sign without --ca), and those of CaOpener,
/// Authority::sign_document and write_new_file.
Result<std::vector<WrittenFile>> write_document(const std::string& xml, const Arguments& arguments,
                                                const Context& context);

}  // namespace ddssec::cli
