// Governance and permissions documents as commands read and write them.
#pragma once

#include <filesystem>
#include <vector>

#include "base/clock.hpp"
#include "cli/command.hpp"
#include "governance/model.hpp"
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

/// What the option says, "3" or "0-5" each. Error: usage.
Result<std::vector<governance::DomainRange>> domain_ranges(const Arguments& arguments,
                                                           std::string_view option);

/// The signature that stands beside a document: its path with the ending p7s.
std::filesystem::path signed_path(const std::filesystem::path& document);

/// Writes a new document to what -o says and, with --sign, its signed form beside it (-o may name
/// either). Both or neither. Errors: usage (--sign without --ca), and those of load_ca,
/// Authority::sign_document and write_new_file.
Result<std::vector<WrittenFile>> write_document(const std::string& xml, const Arguments& arguments,
                                                const Context& context);

}  // namespace ddssec::cli
