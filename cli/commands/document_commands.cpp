// governance, permissions: signing and verifying documents.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "cli/ca/ca_folder.hpp"
#include "cli/ca/governance_revision.hpp"
#include "cli/ca/mistyped_subjects.hpp"
#include "cli/ca/renewal_list.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/ca/signing_warnings.hpp"
#include "cli/commands/groups.hpp"
#include "cli/doctor/products.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/granted_domains.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_file.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "governance/doctor/loaded_folder.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/subject_form.hpp"
#include "governance/grant.hpp"
#include "governance/lint.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

std::vector<Finding> lint_before_signing(const governance::Governance& document, std::size_t,
                                         WallTime) {
  return lint(document);
}
std::vector<Finding> lint_before_signing(const governance::Permissions& document,
                                         std::size_t octets, WallTime now) {
  return lint(document, {.now = now, .signed_octets = octets});
}

struct Signing {
  static constexpr std::string_view kDef = "signing";
  fs::path file;
  std::string signer;
  std::optional<std::uint64_t> revision;

  static constexpr auto fields() {
    return std::tuple(field<&Signing::file>(), field<&Signing::signer>({.def = "subject"}),
                      field<&Signing::revision>({.note = "of a governance document that has one",
                                                 .def = "revision",
                                                 .omits_empty = true}));
  }
  std::string text() const {
    return fmt::format("{}  signed by {}{}\n", file.string(), signer,
                       revision ? fmt::format(", revision {}", *revision) : "");
  }
};

Answer<Signing> not_signed(const fs::path& file, std::vector<Finding> findings) {
  Answer<Signing> out{.result = {}, .has_result = false};
  out.report.text = fmt::format("{}: not signed: {} (--no-lint signs it anyway)\n", file.string(),
                                counts_text(findings));
  add_findings(out.report, std::move(findings), file);
  return out;
}

// A warning if the participant in whose folder the document is put has no grant in it.
void diagnose_own_grant(const governance::Permissions& document,
                        const pki::ParticipantFolder& paths, const fs::path& file,
                        std::vector<Finding>& findings) {
  const auto certificate = read_certificate(paths.certificate);
  if (!certificate) return;
  const auto subject = pki::SubjectName::of(*certificate);
  const auto is_own = [&](const governance::Grant& grant) {
    return governance::is_for(grant, subject);
  };
  if (std::ranges::any_of(document.grants, is_own)) return;
  findings.push_back(
      {.rule = Rule::DOC010,
       .message = fmt::format("the document has no grant for {}, the subject of {}: this "
                              "participant cannot start with it",
                              certificate->subject(), paths.certificate.string()),
       .document = file,
       .severity = Severity::warning});
}

// Grants are compared with the certificate and the governance document beside the result, because
// the participant uses these, and with the certificates that the CA has issued.
std::vector<Finding> unfit_for_participants(const governance::Governance&, const fs::path&,
                                            const fs::path&, const fs::path&) {
  return {};
}
std::vector<Finding> unfit_for_participants(const governance::Permissions& document,
                                            const fs::path& to, const fs::path& file,
                                            const fs::path& ca) {
  const auto paths = pki::participant_folder(folder_of(to));
  auto out = uncovered_grants(document, paths.governance, file);
  if (to.filename() == paths.permissions.filename()) diagnose_own_grant(document, paths, file, out);
  std::ranges::move(mistyped_subjects(document, ca, file), std::back_inserter(out));
  return out;
}

void warn_after_signing(const governance::Governance&, const fs::path&, const Arguments&,
                        WallTime) {}
void warn_after_signing(const governance::Permissions& document, const fs::path& to,
                        const Arguments& arguments, WallTime now) {
  warn_of_extension(document, to, arguments.text("--ca"), now);
}

// The text to sign: for a governance document with the next revision.
Result<NumberedText> text_to_sign(const governance::Governance& document, BytesView xml,
                                  const fs::path& to, const OpenCa& ca,
                                  const Arguments& arguments) {
  if (arguments.has("--no-revision")) return NumberedText{to_bytes(xml), document.revision};
  return with_next_revision(document, xml, to, ca);
}
Result<NumberedText> text_to_sign(const governance::Permissions&, BytesView xml, const fs::path&,
                                  const OpenCa&, const Arguments&) {
  return NumberedText{to_bytes(xml)};
}

// True if sessions of the participants can continue with the document.
bool extends_former(const governance::Governance&, const fs::path&, const OpenCa&, WallTime) {
  return false;
}
bool extends_former(const governance::Permissions& document, const fs::path& to, const OpenCa& ca,
                    WallTime now) {
  auto former = listed_grants(ca.paths, now);
  const auto proof = verified(to, ca.paths.certificate, now);
  const auto log = read_signing_log(ca.paths);
  if (proof && log &&
      log->standing(proof->content(), proof->signer()) == pki::SigningLog::Standing::current)
    if (auto old = governance::read_permissions(proof->content(), proof->first_line()))
      std::ranges::move(old->grants, std::back_inserter(former));
  return extends_any_grant(document, former);
}

Status list_signed(const OpenCa& ca, BytesView signed_octets, const fs::path& to, WallTime now) {
  RenewalListAdditions listed;
  listed.add(ca.paths, signed_octets, to);
  return listed.write(now);
}

// A document that cannot be parsed, or in which lint finds errors, is not signed.
template <class Kind>
Result<Answer<Signing>> sign(const Arguments& arguments, const Context& context) {
  const fs::path from = arguments.text("FILE");
  const fs::path to = arguments.has("-o") ? fs::path(arguments.text("-o")) : signed_path(from);
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(from, pki::kMaxDocumentOctets));
  if (pki::examine_document(octets).wrapping == pki::DocumentWrapping::multipart)
    return fail(Code::usage,
                {.document = from, .field = "FILE", .note = "it is signed already; give the XML"});
  DDSSEC_ASSIGN_OR_RETURN(const auto document, with_default_document(Kind::read(octets), from));
  Report report;
  if (!arguments.has("--no-lint")) {
    auto findings =
        lint_before_signing(document, signed_size(octets), context.clock.calendar_seconds());
    if (governance::has_errors(findings)) return not_signed(from, std::move(findings));
    add_findings(report, std::move(findings), from);
  }
  for (auto& finding : unfit_for_participants(document, to, from, arguments.text("--ca")))
    report.findings.push_back(std::move(finding));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, CaOpener(arguments).open("permissions"));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto text,
      with_default_document(text_to_sign(document, octets, to, ca, arguments), from));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto signed_octets,
      with_default_document(
          ca.authority.sign_document(text.octets, context.clock.calendar_seconds(), context.random),
          from));
  if (const auto size = signed_octets.size(); std::is_same_v<Kind, PermissionsKind> &&
                                              size > pki::kMaxSentPermissionsOctets &&
                                              !arguments.has("--no-lint"))
    return not_signed(from, {governance::too_long_for_peers(size)});
  DDSSEC_RETURN_IF_ERROR(check_result_place(to, arguments));
  const bool is_extension = extends_former(document, to, ca, context.clock.calendar_seconds());
  DDSSEC_RETURN_IF_ERROR(log_signed(
      ca.paths, signed_line(ca.certificate(), text, to, context.clock.calendar_seconds())));
  DDSSEC_ASSIGN_OR_RETURN(auto written, write_result(to, signed_octets, arguments));
  report.files_written.push_back(std::move(written));
  const auto listed = is_extension
                          ? list_signed(ca, signed_octets, to, context.clock.calendar_seconds())
                          : Status();
  if (!listed) report.errors.push_back(listed.error());
  warn_after_signing(document, to, arguments, context.clock.calendar_seconds());
  return Answer<Signing>{{to, ca.certificate().subject(),
                          text.revision == 0 ? std::nullopt : std::optional(text.revision)},
                         std::move(report)};
}

// The judgement of each product about the signature.
struct Verdicts {
  static constexpr std::string_view kDef = "signature_verdicts";
  bool ddssec = false, cyclonedds = false, fastdds = false;
  doctor::Lineup lineup = installed_lineup();

  std::string_view of(doctor::Product product) const {
    const bool accepts = product == doctor::Product::cyclonedds ? cyclonedds
                         : product == doctor::Product::fastdds  ? fastdds
                                                                : ddssec;
    return accepts ? "accepts" : "refuses";
  }
  Json json() const {
    Json out = Json::object();
    for (const auto product : doctor::kProducts) out[doctor::id(product, lineup)] = of(product);
    return out;
  }
  // For example "Cyclone DDS 0.10.2 refuses it, Fast DDS 2.9.1 accepts it".
  std::string in_words() const {
    const auto words = [&](doctor::Product product) {
      return fmt::format("{} {} it", doctor::name(product, lineup), of(product));
    };
    return words(doctor::Product::cyclonedds) + ", " + words(doctor::Product::fastdds);
  }
};
constexpr FieldOptions kVerdicts{.note = "by vendor: accepts, refuses"};

struct Verification {
  fs::path file;
  std::string signer, signer_sha256;
  WallTime signer_not_after;
  Verdicts verdicts;

  static constexpr auto fields() {
    using Self = Verification;
    return std::tuple(field<&Self::file>(), field<&Self::signer>({.def = "subject"}),
                      field<&Self::signer_sha256>({.def = "sha256"}),
                      field<&Self::signer_not_after>(), field<&Self::verdicts>(kVerdicts));
  }
  std::string text() const {
    return fmt::format("{}: signed by {}, valid until {}\n{}", file.string(), signer,
                       date(signer_not_after),
                       verdicts.cyclonedds && verdicts.fastdds
                           ? ""
                           : fmt::format("signature: {}\n", verdicts.in_words()));
  }
};

// ddssec accepts only the CA itself as signer, so stock products may accept a document that ddssec
// refuses (CVE-2023-24010).
struct Refusal {
  static constexpr std::string_view kWhen = "refused";
  Verdicts verdicts;

  static constexpr auto fields() { return std::tuple(field<&Refusal::verdicts>({"the same"})); }
  std::string text() const { return fmt::format("refused; {}\n", verdicts.in_words()); }
};

// The signature as ddssec verified it, and the verdict of each product.
struct SignatureVerdicts {
  Result<pki::SignedDocument> ddssec;
  Verdicts verdicts = {};
};

Result<SignatureVerdicts> signature_verdicts(const fs::path& file, const fs::path& ca,
                                             WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxDocumentOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto file_octets, read_file(ca, pki::kMaxBundleOctets));
  DDSSEC_ASSIGN_OR_RETURN(
      const Result<std::vector<pki::Certificate>> anchors,
      with_default_document(pki::Certificate::bundle_from_pem(file_octets), ca));
  const auto verifier = with_default_document(pki::DocumentVerifier::make(*anchors), ca);
  SignatureVerdicts out{.ddssec = verifier
                                      ? with_default_document(verifier->verify(octets, now), file)
                                      : std::unexpected(verifier.error())};
  // From version 11 on, Cyclone DDS accepts only the CA itself as signer, like ddssec.
  auto& verdicts = out.verdicts;
  const auto by_another = measured(doctor::Variant::permissions_by_itself, verdicts.lineup);
  const bool is_other_signer =
      !out.ddssec && out.ddssec.error().code() == Code::smime_signer_not_permissions_ca;
  const auto accepts = [&](doctor::Product product) {
    return verify_signature_as(product, octets, anchors, {}, now) &&
           !(is_other_signer && by_another.of(product) == doctor::Outcome::fail);
  };
  verdicts.ddssec = out.ddssec.has_value();
  verdicts.cyclonedds = accepts(doctor::Product::cyclonedds);
  verdicts.fastdds = accepts(doctor::Product::fastdds);
  return out;
}

// Names the products for which a grant's spelling of the subject does not match the certificate, as
// measured with each.
void name_products(std::vector<Finding>& findings, const governance::Permissions& document,
                   const pki::Certificate& certificate) {
  for (auto& finding : findings) {
    if (finding.rule != Rule::PERM011 || finding.severity >= Severity::error) continue;
    const auto grant = std::ranges::find(document.grants, finding.line, &governance::Grant::line);
    if (grant == document.grants.end()) continue;
    const auto outcomes =
        doctor::reads_subject(grant->subject_name, certificate, installed_lineup());
    finding.products.clear();
    if (outcomes.cyclonedds != doctor::Outcome::ok) finding.products.emplace_back("cyclonedds");
    if (outcomes.fastdds != doctor::Outcome::ok || grant->subject_has_line_breaks)
      finding.products.emplace_back("fastdds");
  }
}

Result<std::vector<Finding>> lint_for_products(const governance::Governance& document,
                                               const Arguments&, WallTime) {
  return lint(document);
}
Result<std::vector<Finding>> lint_for_products(const governance::Permissions& document,
                                               const Arguments& arguments, WallTime now) {
  if (!arguments.has("--cert")) return lint(document, {.now = now});
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_of(arguments.text("--cert")));
  auto findings = lint(document, {.now = now, .certificate = &certificate});
  name_products(findings, document, certificate);
  return findings;
}

using Verified = Answer<std::variant<Verification, Refusal>>;

template <class Kind>
Result<Verified> verify(const Arguments& arguments, const Context& context) {
  const auto file = document_path<Kind>(arguments.text("FILE"));
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(
      const auto all,
      signature_verdicts(file, ca_certificate_path(arguments.text("--ca"), "permissions"), now));
  if (!all.ddssec) return Verified{Refusal{all.verdicts}, report_of(all.ddssec.error())};
  const auto& proof = all.ddssec;
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      with_default_document(Kind::read(proof->content(), proof->first_line()), file));
  const auto& signer = proof->signer();
  Verified out{Verification{file, signer.subject(), to_hex(signer.fingerprint()),
                            proof->signer_not_after(), all.verdicts}};
  DDSSEC_ASSIGN_OR_RETURN(auto findings, lint_for_products(document, arguments, now));
  add_findings(out.report, std::move(findings), file);
  return out;
}

const Option kCaCertificate{.name = "--ca",
                            .value = "FILE",
                            .summary = "the permissions CA's certificate",
                            .required = true};

std::vector<Option> signing_options() {
  return {ca_option("the folder that ca create made"),
          {"-o", "FILE", "the signed document, if not FILE with the ending p7s"},
          {"--no-lint", "", "sign although lint finds errors"},
          kReplace,
          kPassphraseFile,
          kPassphraseEnv,
          kInsecureKeyMode};
}

std::vector<Option> with_option(std::vector<Option> options, const Option& more) {
  options.push_back(more);
  return options;
}

}  // namespace

std::vector<Command> document_commands() {
  return {
      {.group = "governance",
       .name = "sign",
       .summary = "Signs a governance document that lint passes, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = with_option(signing_options(), kNoRevision),
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
