// Reads documents that a permissions CA signed, and the CA's log of them. A stolen key may have
// signed a document in a participant's folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/command.hpp"
#include "pki/signing_log.hpp"

namespace ddssec::cli {

/// Returns the names of a file in the CA's log: as it is given, and without symbolic links in its
/// folder.
std::vector<std::string> logged_names(const std::filesystem::path& file);

/// Returns the line of the CA's log for a document signed for `file`, for each of logged_names.
std::string signed_line(const pki::Certificate& ca, BytesView text,
                        const std::filesystem::path& file, WallTime now, BytesView extended = {});

/// Appends whole lines to the CA's log. Call it as the last step before files are put in place.
/// Errors: interrupted, length_out_of_range, those of append_lines.
Status log_signed(const CaPaths& ca, std::string_view lines);
/// As log_signed above, for one document. `extended` is the text that the document repeats for a
/// longer time, if there is one (SigningLog::signed_line).
Status log_signed(const OpenCa& ca, BytesView text, const std::filesystem::path& file, WallTime now,
                  BytesView extended = {});

/// Reads the log of what the CA signed; empty if it has no log. Unreadable lines become notices
/// (notice_unreadable_lines). Errors: those of read_file.
Result<pki::SigningLog> read_signing_log(const CaPaths& ca);

/// A document in a participant's folder that the CA's key signed.
struct DocumentOfCa {
  std::string text;       ///< with LF as line ends
  bool is_logged = true;  ///< false: accepted because of an option
};

/// Reads a document for the CA's successor. It is verified as the plugins verify it, but at a time
/// at which the CA was valid, and it must be in the CA's log. A text that the log has as the last
/// one of a file is accepted even without the CA's signature: if an earlier rotation could not
/// replace a document, it has the signature of an earlier CA. With `takes_unlogged`, any document
/// that the key signed is accepted. Errors: document_unlogged, document_superseded, those of
/// DocumentVerifier.
Result<DocumentOfCa> document_of(const std::filesystem::path& file, const OpenCa& ca,
                                 const pki::SigningLog& log, bool takes_unlogged, WallTime now);

/// As document_of, for a document that a former key of the CA signed, of a participant that an
/// earlier rotation did not reach. It is verified with the participant's own CA file, `trusted`;
/// its text and the key that signed it must be in the CA's log. Errors: document_unlogged,
/// document_superseded, those of verified().
Result<DocumentOfCa> document_of_former_key(const std::filesystem::path& file,
                                            const std::filesystem::path& trusted, const OpenCa& ca,
                                            const pki::SigningLog& log, WallTime now);

/// True if a CA signed the document. The CA's certificate is the first one in `trust_pem`. The
/// document is verified at a time at which the CA was valid.
bool is_signed_by(const std::filesystem::path& file, std::string_view trust_pem, WallTime now);

}  // namespace ddssec::cli
