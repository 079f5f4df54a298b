// Numbers the revisions of governance documents, which running participants compare.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/command.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// A document as it is signed.
struct NumberedText {
  Bytes octets;
  std::uint32_t revision = 0;  ///< the revision in `octets`; 0: none
};

/// Returns the document as it is to be signed for `file`. It keeps its own revision if that is
/// higher than the last one in the CA's log and the one in the file that it replaces; a document
/// without one gets the next revision. Error: governance_revision_used (its own revision is not
/// higher, or no higher one exists), those of read_signing_log.
Result<NumberedText> with_next_revision(const governance::Governance& document, BytesView xml,
                                        const std::filesystem::path& file, const OpenCa& ca);

/// Returns the revision of the document in the file, which may be signed. 0 if there is none.
std::uint32_t revision_of(const std::filesystem::path& file);

/// Returns the line of the CA's log for a document signed for `file`.
std::string signed_line(const pki::Certificate& ca, const NumberedText& text,
                        const std::filesystem::path& file, WallTime now);

/// Returns the document with the first revision, for a new CA.
NumberedText with_first_revision(std::string_view xml);

}  // namespace ddssec::cli
