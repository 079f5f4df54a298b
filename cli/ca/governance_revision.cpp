#include "cli/ca/governance_revision.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {

std::uint32_t revision_of(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return 0;
  const auto document = unverified_document<GovernanceKind>(file);
  return document ? document->revision : 0;
}

std::string signed_line(const pki::Certificate& ca, const NumberedText& text,
                        const std::filesystem::path& file, WallTime now) {
  auto line = signed_line(ca, text.octets, file, now);
  return text.revision == 0 ? line : pki::SigningLog::with_revision(line, text.revision);
}

NumberedText with_first_revision(std::string_view xml) {
  return {to_bytes(as_bytes(governance::with_revision(xml, 1))), 1};
}

Result<NumberedText> with_next_revision(const governance::Governance& document, BytesView xml,
                                        const std::filesystem::path& file, const OpenCa& ca) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_signing_log(ca.paths));
  const auto last = std::max(log.last_revision(), revision_of(file));
  if (document.revision > last) return NumberedText{to_bytes(xml), document.revision};
  if (document.revision != 0 || last == std::numeric_limits<std::uint32_t>::max())
    return fail(tool_code::governance_revision_used,
                {.field = "revision",
                 .expected = fmt::format("more than {}", last),
                 .found = document.revision == 0 ? "none" : std::to_string(document.revision)});
  return NumberedText{to_bytes(as_bytes(governance::with_revision(as_text(xml), last + 1))),
                      last + 1};
}

}  // namespace ddssec::cli
