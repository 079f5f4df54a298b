// governance, permissions: signing and verifying documents.
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "cli/ca_folder.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/transaction.hpp"
#include "governance/doctor/subject_form.hpp"
#include "governance/lint.hpp"
#include "pki/smime_diagnosis.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

std::vector<Finding> lint_before_signing(const governance::Governance& document, WallTime) {
  return lint(document);
}
std::vector<Finding> lint_before_signing(const governance::Permissions& document, WallTime now) {
  return lint(document, {.now = now});
}

// A document that cannot be read, or that lint finds errors in, is not worth a signature.
template <class Kind>
Result<Report> sign(const Arguments& arguments, const Context& context) {
  const fs::path from = arguments.text("FILE");
  const fs::path to = arguments.has("-o") ? fs::path(arguments.text("-o")) : signed_path(from);
  const auto octets = DDSSEC_TRY(read_file(from, pki::kMostDocumentOctets));
  if (pki::examine_document(octets).wrapping == pki::DocumentWrapping::multipart)
    return fail(Code::usage,
                {.document = from, .field = "FILE", .note = "it is signed already; give the XML"});
  const auto document = DDSSEC_TRY(named(Kind::read(octets), from));
  Report report;
  if (!arguments.has("--no-lint")) {
    auto findings = lint_before_signing(document, context.clock.now());
    const auto count = counted(findings);
    add_findings(report, std::move(findings), from);
    if (report.exit != Exit::done) {
      report.text =
          fmt::format("{}: not signed: {} (--no-lint signs all the same)\n", from.string(), count);
      return report;
    }
  }
  const auto ca = DDSSEC_TRY(CaOpener(arguments).open("permissions"));
  const auto signed_octets = DDSSEC_TRY(
      named(ca.authority.sign_document(octets, context.clock.now(), context.random), from));
  report.files_written.push_back(DDSSEC_TRY(write_new_file(to, signed_octets, 0644)));
  report.text += fmt::format("{}  signed by {}\n", to.string(), ca.certificate().subject());
  report.result = {{"file", to.string()}, {"signer", ca.certificate().subject()}};
  return report;
}

/// What comes of the signature with each product.
struct Beliefs {
  Result<pki::SignedDocument> ours;
  bool stock = false;
};

Result<Beliefs> beliefs(const fs::path& file, const fs::path& ca, WallTime now) {
  const auto octets = DDSSEC_TRY(read_file(file, pki::kMostDocumentOctets));
  auto anchors = DDSSEC_TRY(named(
      pki::Certificate::bundle_from_pem(DDSSEC_TRY(read_file(ca, pki::kMostBundleOctets))), ca));
  const bool stock = pki::stock_products_believe(octets, anchors, now).has_value();
  const auto verifier = DDSSEC_TRY(named(pki::DocumentVerifier::make(std::move(anchors)), ca));
  return Beliefs{named(verifier.verify(octets, now), file), stock};
}

std::string_view word(bool accepted) { return accepted ? "accepts" : "refuses"; }

Json verdicts_json(bool stock, bool ours) {
  return {{"cyclonedds@0.10.2", word(stock)}, {"fastdds@2.9.1", word(stock)}, {"ours", word(ours)}};
}

// Ours pins the signer, so that stock products can believe what ours does not (CVE-2023-24010).
Report refused(const Error& error, bool stock) {
  Report report = report_of(error);
  report.text = fmt::format("refused; Cyclone DDS 0.10.2 and Fast DDS 2.9.1 {}\n",
                            stock ? "would accept it" : "refuse it as well");
  report.result = {{"verdicts", verdicts_json(stock, false)}};
  return report;
}

// Whom a grant's spelling of the subject does not suit, as measured with either product.
void name_vendors(std::vector<Finding>& findings, const governance::Permissions& document,
                  const pki::Certificate& certificate) {
  for (auto& finding : findings) {
    if (finding.rule != Rule::PERM011 || finding.severity >= Severity::error) continue;
    const auto grant = std::ranges::find(document.grants, finding.line, &governance::Grant::line);
    if (grant == document.grants.end()) continue;
    const auto outcomes = doctor::reads_subject(grant->subject_name, certificate);
    finding.vendors.clear();
    if (outcomes.cyclonedds != doctor::Outcome::ok) finding.vendors.emplace_back("cyclonedds");
    if (outcomes.fastdds != doctor::Outcome::ok) finding.vendors.emplace_back("fastdds");
  }
}

Result<std::vector<Finding>> lint_for_vendors(const governance::Governance& document,
                                              const Arguments&, WallTime) {
  return lint(document);
}
Result<std::vector<Finding>> lint_for_vendors(const governance::Permissions& document,
                                              const Arguments& arguments, WallTime now) {
  if (!arguments.has("--cert")) return lint(document, {.now = now});
  const auto certificate = DDSSEC_TRY(read_certificate(certificate_path(arguments.text("--cert"))));
  auto findings = lint(document, {.now = now, .certificate = &certificate});
  name_vendors(findings, document, certificate);
  return findings;
}

template <class Kind>
Result<Report> verify(const Arguments& arguments, const Context& context) {
  const auto file = document_path<Kind>(arguments.text("FILE"));
  const auto now = context.clock.now();
  const auto [proof, stock] =
      DDSSEC_TRY(beliefs(file, ca_certificate_path(arguments.text("--ca"), "permissions"), now));
  if (!proof) return refused(proof.error(), stock);
  const auto document = DDSSEC_TRY(named(Kind::read(proof->content()), file));
  Report report;
  report.text = fmt::format("{}: signed by {}, valid until {}\n", file.string(),
                            proof->signer().subject(), date(proof->signer_not_after()));
  if (!stock) report.text += "Cyclone DDS 0.10.2 and Fast DDS 2.9.1 refuse the signature\n";
  report.result = {{"file", file.string()},
                   {"signer", proof->signer().subject()},
                   {"signer_sha256", to_hex(proof->signer().fingerprint())},
                   {"signer_not_after", to_string(proof->signer_not_after())},
                   {"verdicts", verdicts_json(stock, true)}};
  add_findings(report, DDSSEC_TRY(lint_for_vendors(document, arguments, now)), file);
  return report;
}

const Option kCaCertificate{.name = "--ca",
                            .value = "FILE",
                            .summary = "the permissions CA's certificate",
                            .required = true};

std::vector<Option> signing_options() {
  return {ca_option("the folder that ca create made"),
          {"-o", "FILE", "the signed document, if not FILE with the ending p7s"},
          {"--no-lint", "", "sign although lint finds errors"},
          kPassphraseFile,
          kPassphraseEnv,
          kInsecureKeyMode};
}

}  // namespace

std::vector<Command> document_commands() {
  return {
      {.group = "governance",
       .name = "sign",
       .summary = "Signs a governance document that lint passes, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec governance sign governance.xml --ca ca"},
       .run = sign<GovernanceKind>},
      {.group = "governance",
       .name = "verify",
       .summary = "Verifies a signed governance document, and says which product refuses what.",
       .positionals = {{"FILE", "the signed document, or the participant's folder"}},
       .options = {kCaCertificate},
       .examples = {"ddssec governance verify governance.p7s --ca ca/permissions/ca.pem"},
       .run = verify<GovernanceKind>},
      {.group = "permissions",
       .name = "sign",
       .summary = "Signs a permissions document that lint passes, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec permissions sign permissions.xml --ca ca -o talker/permissions.p7s"},
       .run = sign<PermissionsKind>},
      {.group = "permissions",
       .name = "verify",
       .summary = "Verifies a signed permissions document, and says which product refuses what.",
       .positionals = {{"FILE", "the signed document, or the participant's folder"}},
       .options = {kCaCertificate, {"--cert", "FILE", "the certificate that it is for"}},
       .examples = {"ddssec permissions verify permissions.p7s --ca ca/permissions/ca.pem "
                    "--cert cert.pem"},
       .run = verify<PermissionsKind>}};
}

}  // namespace ddssec::cli
