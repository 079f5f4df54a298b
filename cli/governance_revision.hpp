// The revisions of governance documents, which running participants compare.
#pragma once

#include <filesystem>

#include "cli/ca_folder.hpp"
#include "cli/command.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// The document as it is to be signed for `file`: its own revision, if that is higher than the last
/// one of the CA's log and that of the file which it replaces, or else the next one is written into
/// it. Error: governance_revision_used (its own one is not higher, or there is no higher one),
/// those of read_signing_log.
Result<Bytes> with_next_revision(const governance::Governance& document, BytesView xml,
                                 const std::filesystem::path& file, const OpenCa& ca);

}  // namespace ddssec::cli
