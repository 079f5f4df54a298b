// Documents that a permissions CA signs, and its log of them: what lies in a participant's folder
// under the CA's signature may be what a thief of the key signed.
#pragma once

#include <filesystem>
#include <string>

#include "cli/ca_folder.hpp"
#include "cli/command.hpp"
#include "pki/signing_log.hpp"

namespace ddssec::cli {

/// The line of the CA's log that says that it signed a document for `file`.
std::string signed_line(const pki::Certificate& ca, BytesView text,
                        const std::filesystem::path& file, WallTime now);

/// Adds lines to the CA's log, each whole. The last step before files get their places. Errors:
/// interrupted, length_out_of_range, those of append_lines.
Status log_signed(const CaPaths& ca, std::string_view lines);
/// The same for one document.
Status log_signed(const OpenCa& ca, BytesView text, const std::filesystem::path& file,
                  WallTime now);

/// What the CA signed; nothing if it has no log. Lines that cannot be read are noticed
/// (notice_unreadable_lines). Errors: those of read_file.
Result<pki::SigningLog> read_signing_log(const CaPaths& ca);

/// A document in a participant's folder that the CA's key signed.
struct DocumentOfCa {
  std::string text;       ///< line ends LF
  bool is_logged = true;  ///< false: taken because the command line says so
};

/// Reads a document for the CA's successor: verified as the plugins verify it, but at a time at
/// which the CA was valid, and only what the CA's log knows. A text that the log has as the last
/// one of a file is taken also without the CA's signature: where an earlier rotation could not
/// replace a document, the signature is of the CA before. With `takes_unlogged`, whatever the key
/// signed. Errors: document_unlogged, document_superseded, those of DocumentVerifier.
Result<DocumentOfCa> document_of(const std::filesystem::path& file, const OpenCa& ca,
                                 const pki::SigningLog& log, bool takes_unlogged, WallTime now);

/// True if a CA signed the document: `trust_pem` has its certificate first. Verified at a time at
/// which the CA was valid.
bool is_signed_by(const std::filesystem::path& file, std::string_view trust_pem, WallTime now);

}  // namespace ddssec::cli
