// governance lint, permissions lint: find problems in a document that can be parsed.
#include <optional>

#include <fmt/format.h>

#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/inputs/files.hpp"
#include "governance/lint.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct LintResult {
  static constexpr std::string_view kDef = "linted";
  fs::path file;
  FindingCounts counts;

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&LintResult::file>()),
                          fields_within(&LintResult::counts));
  }
  std::string text() const { return fmt::format("{}: {}\n", file.string(), counts.words()); }
};

Answer<LintResult> linted(const fs::path& file, std::vector<Finding> findings) {
  Answer<LintResult> out{{file, FindingCounts::of(findings)}};
  add_findings(out.report, std::move(findings), file);
  return out;
}

Result<Answer<LintResult>> governance_lint(const Arguments& arguments, const Context&) {
  const auto file = document_path<GovernanceKind>(arguments.text("FILE"));
  DDSSEC_ASSIGN_OR_RETURN(const auto domain, domain_option(arguments));
  const governance::GovernanceUse use{.domain = domain, .choices = true};
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<GovernanceKind>(file));
  return linted(file, lint(document, use));
}

Result<Answer<LintResult>> permissions_lint(const Arguments& arguments, const Context& context) {
  const auto file = document_path<PermissionsKind>(arguments.text("FILE"));
  std::optional<pki::Certificate> certificate;
  std::optional<governance::Governance> governance;
  if (arguments.has("--cert")) {
    DDSSEC_ASSIGN_OR_RETURN(certificate, certificate_of(arguments.text("--cert")));
  }
  if (arguments.has("--governance")) {
    DDSSEC_ASSIGN_OR_RETURN(governance,
                            unverified_document<GovernanceKind>(
                                document_path<GovernanceKind>(arguments.text("--governance"))));
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxDocumentOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, unverified_document<PermissionsKind>(file));
  return linted(file, lint(document, {.now = context.clock.calendar_seconds(),
                                      .certificate = certificate ? &*certificate : nullptr,
                                      .governance = governance ? &*governance : nullptr,
                                      .signed_octets = signed_size(octets)}));
}

const Positional kDocument{
    "FILE", "the document, XML or signed, or a participant's folder (no signature is verified)"};

}  // namespace

std::vector<Command> lint_commands() {
  return {
      {.group = "governance",
       .name = "lint",
       .summary = "Says what is unused, weak or read differently by some product; exit 1: errors.",
       .positionals = {kDocument},
       .options = {{"--domain", "N", "the domain it is meant for"}},
       .examples = {"ddssec governance lint governance.xml --domain 0"},
       .run = governance_lint},
      {.group = "permissions",
       .name = "lint",
       .summary = "Says what is unused, wrong or read differently by some product; exit 1: errors.",
       .positionals = {kDocument},
       .options = {{"--cert", "FILE", "the certificate that it is for"},
                   {"--governance", "FILE", "the governance document that it goes with"}},
       .examples = {"ddssec permissions lint permissions.xml --cert talker/cert.pem "
                    "--governance governance.xml"},
       .run = permissions_lint}};
}

}  // namespace ddssec::cli
