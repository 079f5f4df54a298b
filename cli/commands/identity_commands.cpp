// identity show, csr, sign-csr: certificates, and keys that never leave their device.
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/subject_overlap.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/participant_options.hpp"
#include "cli/inputs/passphrase.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/participant.hpp"
#include "governance/doctor/meeting.hpp"
#include "pki/certificate_source.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct ShownIdentity {
  std::string subject, issuer, algorithm, serial;
  WallTime not_before, not_after;
  bool valid_now;
  std::string sha256, guid_start;

  static constexpr auto fields() {
    using Self = ShownIdentity;
    return std::tuple(
        field<&Self::subject>({.def = "subject"}), field<&Self::issuer>({.def = "subject"}),
        field<&Self::algorithm>({.def = "algorithm"}), field<&Self::serial>({.def = "serial"}),
        field<&Self::not_before>(), field<&Self::not_after>(), field<&Self::valid_now>(),
        field<&Self::sha256>({.def = "sha256"}),
        field<&Self::guid_start>({.note = "48 bits, in hexadecimal", .pattern = "^[0-9a-f]{12}$"}));
  }
  std::string text() const {
    return fmt::format(
        "subject  {}\nissuer   {}\nkey      {}\nserial   {}\nvalid    {} .. {}\nsha256   {}\n"
        "guid     {}...  (whose GUID is lower, starts the handshake)\n",
        subject, issuer, algorithm, serial, date(not_before), date(not_after), sha256, guid_start);
  }
};

Result<Answer<ShownIdentity>> identity_show(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_of(arguments.text("PATH")));
  const auto now = context.clock.calendar_seconds();
  const bool valid = certificate.not_before() <= now && now <= certificate.not_after();
  Answer<ShownIdentity> out{
      {.subject = certificate.subject(),
       .issuer = certificate.issuer(),
       .algorithm = std::string(to_string(certificate.key_algorithm())),
       .serial = certificate.serial(),
       .not_before = certificate.not_before(),
       .not_after = certificate.not_after(),
       .valid_now = valid,
       .sha256 = to_hex(certificate.fingerprint()),
       .guid_start = fmt::format("{:012x}", governance::doctor::guid_start(certificate))}};
  if (valid) return out;
  out.report.exit = Exit::no;
  out.report.errors.emplace_back(
      now < certificate.not_before() ? Code::certificate_not_yet_valid : Code::certificate_expired,
      ErrorDetails{.document = certificate_path(arguments.text("PATH")), .found = to_string(now)});
  return out;
}

struct MadeRequest {
  std::string name;
  fs::path dir;
  std::string subject, algorithm;
  fs::path request;
  bool in_token;  // true if the key is in a token

  static constexpr auto fields() {
    return std::tuple(field<&MadeRequest::name>(), field<&MadeRequest::dir>(),
                      field<&MadeRequest::subject>({.def = "subject"}),
                      field<&MadeRequest::algorithm>({.def = "algorithm"}),
                      field<&MadeRequest::request>());
  }
  std::string text() const {
    return fmt::format("{}  a key, which stays {}, and request.pem for {}\n", dir.string(),
                       in_token ? "in its token" : "here", subject);
  }
};

Result<Answer<MadeRequest>> identity_csr(const Arguments& arguments, const Context&) {
  const auto name = arguments.text("NAME");
  DDSSEC_RETURN_IF_ERROR(check_name(name));
  const fs::path target = arguments.text("-o");
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(target));
  const auto subject = arguments.has("--subject") ? arguments.text("--subject") : "CN=" + name;
  DDSSEC_ASSIGN_OR_RETURN(const auto made, new_key(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto request, pki::make_request(made.key, subject));
  DDSSEC_RETURN_IF_ERROR(add_key(folder, "key.pem", made));
  DDSSEC_RETURN_IF_ERROR(folder.add_public("request.pem", request));
  Answer<MadeRequest> out{{.name = name,
                           .dir = target,
                           .subject = subject,
                           .algorithm = std::string(to_string(made.key.algorithm())),
                           .request = target / "request.pem",
                           .in_token = !made.token_uri.empty()}};
  out.report.text = "next, where the CA is: ddssec identity sign-csr request.pem --ca CA\n";
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, folder.commit());
  return out;
}

// The request's subject becomes the participant's name, so the user must have checked it.
Status confirm_request(const pki::RequestContent& content, const Arguments& arguments) {
  if (arguments.has("--yes")) return {};
  return confirm(fmt::format("issue a certificate for \"{}\", key {}?", content.subject,
                             to_string(content.key)));
}

// Permissions and revocation use the subject, so a second key for the same subject would be a
// second participant with the rights of the first.
Status check_subject_free(const pki::Certificate& certificate, const pki::IssueLog& log,
                          const Arguments& arguments, WallTime now) {
  if (arguments.has("--another-key")) return {};
  DDSSEC_RETURN_IF_ERROR(SubjectsInUse(log, {}, now).check(certificate.subject()));
  const pki::KeyDigests key(certificate);
  const auto wanted = pki::SubjectName::of(certificate).key();
  for (const auto& issued : log.issued()) {
    if (issued.revoked || issued.not_after <= now || key.contains(issued.key)) continue;
    const auto subject = pki::SubjectName::parse(issued.subject);
    if (!subject || subject->key() != wanted) continue;
    return fail(Code::subject_taken,
                {.found = fmt::format("{}, serial {}, valid until {}, {}", issued.subject,
                                      issued.serial, date(issued.not_after), issued.place())});
  }
  return {};
}

// A participant with the name of a CA could not be distinguished from it. A participant with such a
// name or without one could not be revoked or given permissions by its name either.
Status check_subject_of_request(const std::string& subject, const OpenCa& ca,
                                const Arguments& arguments) {
  if (subject.empty())
    return fail(Code::subject_name_malformed, {.found = "a request without a subject name"});
  DDSSEC_ASSIGN_OR_RETURN(const auto subject_name, pki::SubjectName::parse(subject));
  const auto wanted = subject_name.key();
  const auto is_of = [&](const pki::Certificate& certificate) {
    return pki::SubjectName::of(certificate).key() == wanted;
  };
  const auto other = ca_paths(arguments.text("--ca"), "permissions").certificate;
  const auto permissions = read_certificate(other);
  const bool is_taken = is_of(ca.certificate()) || (permissions && is_of(*permissions));
  if (!is_taken) return {};
  return fail(Code::subject_taken, {.found = subject + ", which is a CA's",
                                    .hint = "make a request with another subject name"});
}

// Lists other certificates of the same key, which stay valid until they are revoked.
std::string same_key_text(const pki::Certificate& certificate, const pki::IssueLog& log,
                          WallTime now) {
  std::string out;
  const pki::KeyDigests key(certificate);
  for (const auto& issued : log.issued())
    if (!issued.revoked && now < issued.not_after && key.contains(issued.key) &&
        issued.subject != certificate.subject())
      out += fmt::format("note: of the same key: serial {}  {}\n", issued.serial, issued.subject);
  return out;
}

// The next step with the permissions CA of --ca, or in general words if there is only an identity
// CA.
std::string after_signing(const fs::path& to, const OpenCa& ca, const std::string& given) {
  const auto permissions = ca_paths(given, "permissions").certificate;
  const bool has_both = permissions != ca.paths.certificate;
  return fmt::format(
      "next, for its permissions: ddssec permissions new --cert {0} --publish TOPIC --sign --ca "
      "{1} -o {2}\n"
      "and to the device, beside its key: {0}, {3} as identity_ca.pem, {4} as permissions_ca.pem, "
      "permissions.p7s, governance.p7s\n",
      to.string(), has_both ? given : "PERMISSIONS_CA",
      fs::path(to).replace_filename("permissions.xml").string(), ca.paths.certificate.string(),
      has_both ? permissions.string() : "the permissions CA's certificate");
}

struct SignedRequest {
  fs::path file;
  std::string algorithm;
  CertificateFacts certificate;

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&SignedRequest::file>(),
                                     field<&SignedRequest::algorithm>({.def = "algorithm"})),
                          fields_within(&SignedRequest::certificate));
  }
  std::string text() const {
    return fmt::format("{}  {}  expires {}\n", file.string(), certificate.subject,
                       date(certificate.not_after));
  }
};

Result<Answer<SignedRequest>> identity_sign_csr(const Arguments& arguments,
                                                const Context& context) {
  std::error_code ignored;
  const fs::path given = arguments.text("CSR");
  const auto from = fs::is_directory(given, ignored) ? given / "request.pem" : given;
  const fs::path to =
      arguments.has("-o") ? fs::path(arguments.text("-o")) : from.parent_path() / "cert.pem";
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto wanted, validity(arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto responder, ocsp_responder(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto request, read_file(from, pki::kMaxCertificateOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto content,
                          with_default_document(pki::read_request(request), from));
  DDSSEC_RETURN_IF_ERROR(confirm_request(content, arguments));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  DDSSEC_RETURN_IF_ERROR(
      with_default_document(check_subject_of_request(content.subject, ca, arguments), from));
  DDSSEC_ASSIGN_OR_RETURN(const auto life,
                          within_ca(wanted, ca.certificate(), arguments.has("--clamp")));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate,
                          ca.authority.sign_request(request, life, context.random, responder));
  const auto folder = fs::absolute(to, ignored).lexically_normal().parent_path();
  // Checked before the log is written, so that a refusal leaves nothing.
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca.paths));
  DDSSEC_RETURN_IF_ERROR(check_key_not_revoked(certificate, from, ca.paths, log));
  DDSSEC_RETURN_IF_ERROR(check_subject_free(certificate, log, arguments, now));
  if (fs::symlink_status(to, ignored).type() > fs::file_type::not_found)
    return fail(Code::would_overwrite, {.document = to});
  DDSSEC_RETURN_IF_ERROR(log_issued(
      ca.paths,
      pki::IssueLog::issued_line(certificate, folder.string(), now, to.filename().string())));
  Answer<SignedRequest> out{
      {to, std::string(to_string(content.key)), CertificateFacts::of(certificate)}};
  DDSSEC_ASSIGN_OR_RETURN(auto written, write_new_file(to, as_bytes(certificate.pem()), 0644));
  out.report.files_written.push_back(std::move(written));
  out.report.text =
      same_key_text(certificate, log, now) + after_signing(to, ca, arguments.text("--ca"));
  return out;
}

const Option kNewFolder{
    .name = "-o", .value = "DIR", .summary = "the new folder", .required = true};

}  // namespace

std::vector<Command> identity_commands() {
  return {{.group = "identity",
           .name = "csr",
           .summary = "Makes a key on the device that will keep it, and a request for a CA.",
           .positionals = {{"NAME", "the participant's name"}},
           .options = {kNewFolder, kSubject, kKeyOrToken, kPinFile, kPassphraseEnv},
           .examples = {"ddssec identity csr talker -o talker",
                        "ddssec identity csr talker -o talker --key "
                        "'pkcs11:token=robot;object=talker?pin-source=file:/etc/robot/pin'"},
           .run = identity_csr},
          {.group = "identity",
           .name = "sign-csr",
           .summary = "Issues the certificate that a request asks for.",
           .positionals = {{"CSR", "the request, in PEM, or the folder with request.pem"}},
           .options = {ca_option("the folder that ca create made"),
                       {"-o", "FILE", "the certificate, if not cert.pem beside the request"},
                       {"--yes", "", "do not ask whether subject and key are right"},
                       {"--another-key", "",
                        "also if the subject, or one with a part of its attributes, has a valid "
                        "certificate for another key"},
                       days("365"),
                       kClampToCa,
                       kOcspResponder,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec identity sign-csr talker/request.pem --ca ca --yes"},
           .run = identity_sign_csr},
          {.group = "identity",
           .name = "show",
           .summary = "Shows a certificate; exit 1 if it is not valid now.",
           .positionals = {{"PATH", "a participant's folder or a certificate"}},
           .options = {},
           .examples = {"ddssec identity show talker"},
           .run = identity_show}};
}

}  // namespace ddssec::cli
