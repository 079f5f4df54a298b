// identity: a participant's key, certificate and permissions, from the first day.
#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "cli/documents.hpp"
#include "cli/fleet.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/participant.hpp"
#include "cli/progress.hpp"
#include "cli/transaction.hpp"
#include "governance/doctor/meeting.hpp"
#include "pki/source.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Only what the participant will believe is copied: a document that is not signed, or by another
// CA, would be found out at its first start.
Result<Bytes> governance_of(const Arguments& arguments, WallTime now) {
  if (!arguments.has("--governance")) return Bytes();
  const fs::path file = arguments.text("--governance");
  const auto ca = ca_paths(arguments.text("--ca"), "permissions").certificate;
  DDSSEC_TRY(verified(file, ca, now));
  return read_file(file, pki::kMostDocumentOctets);
}

// What counts for every participant of the command.
Result<ParticipantSpec> common_spec(const Arguments& arguments, WallTime now) {
  ParticipantSpec out{.name = {}, .subject = {}, .life = {}};
  out.life = DDSSEC_TRY(validity(arguments, now));
  out.key = DDSSEC_TRY(key_spec(arguments));
  out.domains = DDSSEC_TRY(domain_ranges(arguments, "--domain"));
  out.publish = DDSSEC_TRY(topics_of(arguments, "--publish"));
  out.subscribe = DDSSEC_TRY(topics_of(arguments, "--subscribe"));
  return out;
}

Result<ParticipantSpec> spec_of(const Arguments& arguments, WallTime now) {
  auto spec = DDSSEC_TRY(common_spec(arguments, now));
  spec.name = arguments.text("NAME");
  DDSSEC_TRY(check_name(spec.name));
  spec.subject = arguments.has("--subject") ? arguments.text("--subject") : "CN=" + spec.name;
  if (!arguments.has("--permissions")) return spec;
  if (spec.has_permissions())
    return fail(Code::usage,
                {.field = "--permissions", .note = "it excludes --publish and --subscribe"});
  spec.permissions =
      DDSSEC_TRY(read_file(arguments.text("--permissions"), pki::kMostDocumentOctets));
  return spec;
}

Json describe(const pki::Certificate& certificate) {
  return {{"subject", certificate.subject()},
          {"serial", certificate.serial()},
          {"not_after", to_string(certificate.not_after())},
          {"sha256", to_hex(certificate.fingerprint())}};
}

// What a participant cannot start without, and this command was not told of.
std::string not_in_it(bool has_permissions, bool has_governance) {
  std::string out;
  if (!has_governance)
    out += "no governance.p7s is in it yet: --governance FILE copies a signed one\n";
  if (!has_permissions)
    out +=
        "no permissions are in it yet: --publish and --subscribe, or --permissions FILE, make "
        "them\n";
  return out;
}

/// Finds participants that neither permissions nor a revocation tell apart.
class Subjects {
 public:
  explicit Subjects(fs::path fleet) : fleet_(std::move(fleet)) {}

  void add(const std::string& name, const pki::Certificate& certificate, Report& report) {
    const auto [first, is_new] = names_.try_emplace(pki::SubjectName::of(certificate).key(), name);
    if (is_new) return;
    report.errors.emplace_back(Code::subject_shared,
                               ErrorDetails{.document = fleet_,
                                            .found = fmt::format("{} and {}: {}", first->second,
                                                                 name, certificate.subject())});
  }

 private:
  fs::path fleet_;
  std::map<std::string, std::string> names_;  // by SubjectName::key()
};

// One command, many participants: all of them or none.
Result<Report> issue_fleet(const Arguments& arguments, const Context& context) {
  const auto now = context.clock.now();
  for (const auto* option : {"--subject", "--permissions"})
    if (arguments.has(option))
      return fail(Code::usage, {.field = option, .note = "with --from it is said in the file"});
  const fs::path from = arguments.text("--from");
  const fs::path target = arguments.text("-o");
  auto specs = DDSSEC_TRY(read_fleet(from, DDSSEC_TRY(common_spec(arguments, now)), now));
  auto folder = DDSSEC_TRY(NewFolder::at(target));
  const auto governance = DDSSEC_TRY(governance_of(arguments, now));
  CaOpener opener(arguments);
  const auto identity = DDSSEC_TRY(opener.open("identity"));
  std::optional<OpenCa> permissions;
  if (std::ranges::any_of(specs, &ParticipantSpec::has_permissions))
    permissions = DDSSEC_TRY(opener.open("permissions"));
  const auto crl = DDSSEC_TRY(list_for_newcomers(identity.paths, now));
  Report report;
  report.result = {{"dir", target.string()}, {"participants", Json::array()}};
  std::string lines;
  Subjects subjects(from);
  Progress progress("participants", specs.size());
  for (auto& spec : specs) {
    spec.life = DDSSEC_TRY(within_ca(spec.life, identity.certificate(), arguments.has("--clamp")));
    const bool has_rights = spec.has_permissions();
    const Issuers issuers{identity, permissions && has_rights ? &*permissions : nullptr, crl};
    const auto made = DDSSEC_TRY(named(make_participant(spec, issuers, context), from));
    DDSSEC_TRY(add_flat(folder, spec.name, made, issuers, governance));
    lines += log_line(made, target / spec.name, now);
    const auto& certificate = made.self.certificate;
    subjects.add(spec.name, certificate, report);
    report.text += fmt::format("{}  {}  expires {}\n", (target / spec.name).string(),
                               certificate.subject(), date(certificate.not_after()));
    Json row = {{"name", spec.name}, {"dir", (target / spec.name).string()}};
    row.update(describe(certificate));
    report.result["participants"].push_back(std::move(row));
    progress.step();
  }
  DDSSEC_TRY(check_not_interrupted());
  DDSSEC_TRY(append_lines(identity.paths.log, lines));
  report.files_written = DDSSEC_TRY(folder.commit());
  return report;
}

Result<Report> identity_issue(const Arguments& arguments, const Context& context) {
  if (arguments.has("--from") == arguments.has("NAME"))
    return fail(Code::usage, {.field = "NAME", .note = "give either a name or --from"});
  if (arguments.has("--from")) return issue_fleet(arguments, context);
  const auto now = context.clock.now();
  auto spec = DDSSEC_TRY(spec_of(arguments, now));
  const fs::path target = arguments.text("-o");
  auto folder = DDSSEC_TRY(NewFolder::at(target));
  const auto governance = DDSSEC_TRY(governance_of(arguments, now));
  CaOpener opener(arguments);
  const auto identity = DDSSEC_TRY(opener.open("identity"));
  std::optional<OpenCa> permissions;
  if (spec.has_permissions()) permissions = DDSSEC_TRY(opener.open("permissions"));
  spec.life = DDSSEC_TRY(within_ca(spec.life, identity.certificate(), arguments.has("--clamp")));
  const auto crl = DDSSEC_TRY(list_for_newcomers(identity.paths, now));
  const Issuers issuers{identity, permissions ? &*permissions : nullptr, crl};
  const auto made =
      DDSSEC_TRY(named(make_participant(spec, issuers, context), arguments.text("--permissions")));
  DDSSEC_TRY(add_flat(folder, "", made, issuers, governance));
  DDSSEC_TRY(check_not_interrupted());
  DDSSEC_TRY(append_lines(identity.paths.log, log_line(made, target, now)));

  Report report;
  const auto& certificate = made.self.certificate;
  report.text = fmt::format("{}  {}  expires {}\n", target.string(), certificate.subject(),
                            date(certificate.not_after()));
  report.text += not_in_it(permissions.has_value(), !governance.empty());
  report.result = {{"name", spec.name}, {"dir", target.string()}};
  report.result.update(describe(certificate));
  report.files_written = DDSSEC_TRY(folder.commit());
  return report;
}

Result<Report> identity_show(const Arguments& arguments, const Context& context) {
  const auto path = certificate_path(arguments.text("PATH"));
  const auto certificate = DDSSEC_TRY(read_certificate(path));
  const auto now = context.clock.now();
  const bool valid = certificate.not_before() <= now && now <= certificate.not_after();
  const auto guid = fmt::format("{:012x}", governance::doctor::guid_start(certificate));
  Report report;
  report.exit = valid ? Exit::done : Exit::no;
  report.text = fmt::format(
      "subject  {}\nissuer   {}\nkey      {}\nserial   {}\nvalid    {} .. {}\nsha256   {}\n"
      "guid     {}...  (whose GUID is lower, starts the handshake)\n",
      certificate.subject(), certificate.issuer(), to_string(certificate.key_algorithm()),
      certificate.serial(), date(certificate.not_before()), date(certificate.not_after()),
      to_hex(certificate.fingerprint()), guid);
  report.result = {{"subject", certificate.subject()},
                   {"issuer", certificate.issuer()},
                   {"algorithm", to_string(certificate.key_algorithm())},
                   {"serial", certificate.serial()},
                   {"not_before", to_string(certificate.not_before())},
                   {"not_after", to_string(certificate.not_after())},
                   {"valid_now", valid},
                   {"sha256", to_hex(certificate.fingerprint())},
                   {"guid_start", guid}};
  if (!valid)
    report.errors.emplace_back(now < certificate.not_before() ? Code::certificate_not_yet_valid
                                                              : Code::certificate_expired,
                               ErrorDetails{.document = path, .found = to_string(now)});
  return report;
}

Result<Report> identity_csr(const Arguments& arguments, const Context&) {
  const auto name = arguments.text("NAME");
  DDSSEC_TRY(check_name(name));
  const fs::path target = arguments.text("-o");
  auto folder = DDSSEC_TRY(NewFolder::at(target));
  const auto subject = arguments.has("--subject") ? arguments.text("--subject") : "CN=" + name;
  const auto made = DDSSEC_TRY(new_key(arguments));
  const auto request = DDSSEC_TRY(pki::make_request(made.key, subject));
  DDSSEC_TRY(add_key(folder, "key.pem", made));
  DDSSEC_TRY(folder.add_public("request.pem", request));
  Report report;
  report.text = fmt::format(
      "{}  a key, which stays {}, and request.pem for {}\n"
      "next, where the CA is: ddssec identity sign-csr request.pem --ca CA\n",
      target.string(), made.token_uri.empty() ? "here" : "in its token", subject);
  report.result = {{"name", name},
                   {"dir", target.string()},
                   {"subject", subject},
                   {"algorithm", to_string(made.key.algorithm())},
                   {"request", (target / "request.pem").string()}};
  report.files_written = DDSSEC_TRY(folder.commit());
  return report;
}

// The request's subject becomes the participant's name: somebody must have looked at it.
Status confirm_request(const pki::RequestContent& content, const Arguments& arguments) {
  if (arguments.has("--yes")) return {};
  return confirm(fmt::format("issue a certificate for \"{}\", key {}?", content.subject,
                             to_string(content.key)));
}

Result<Report> identity_sign_csr(const Arguments& arguments, const Context& context) {
  std::error_code ignored;
  const fs::path given = arguments.text("CSR");
  const auto from = fs::is_directory(given, ignored) ? given / "request.pem" : given;
  const fs::path to =
      arguments.has("-o") ? fs::path(arguments.text("-o")) : from.parent_path() / "cert.pem";
  const auto now = context.clock.now();
  const auto wanted = DDSSEC_TRY(validity(arguments, now));
  const auto request = DDSSEC_TRY(read_file(from, pki::kMostCertificateOctets));
  const auto content = DDSSEC_TRY(named(pki::read_request(request), from));
  DDSSEC_TRY(confirm_request(content, arguments));
  CaOpener opener(arguments);
  const auto ca = DDSSEC_TRY(opener.open("identity"));
  const auto life = DDSSEC_TRY(within_ca(wanted, ca.certificate(), arguments.has("--clamp")));
  const auto certificate = DDSSEC_TRY(ca.authority.sign_request(request, life, context.random));
  const auto folder = fs::absolute(to, ignored).lexically_normal().parent_path();
  // Checked before the log is written, so that a refusal leaves nothing.
  if (fs::symlink_status(to, ignored).type() > fs::file_type::not_found)
    return fail(Code::would_overwrite, {.document = to});
  DDSSEC_TRY(
      append_lines(ca.paths.log, pki::IssueLog::issued_line(certificate, folder.string(), now)));
  Report report;
  report.files_written.push_back(DDSSEC_TRY(write_new_file(to, as_bytes(certificate.pem()), 0644)));
  report.text = fmt::format(
      "{0}  {1}  expires {2}\n"
      "next, for its permissions: ddssec permissions new --cert {0} --publish TOPIC --sign --ca "
      "{3} -o {4}\n"
      "and to the device, beside its key: {0}, {5} as identity_ca.pem, {6} as permissions_ca.pem, "
      "permissions.p7s, governance.p7s\n",
      to.string(), certificate.subject(), date(certificate.not_after()), arguments.text("--ca"),
      fs::path(to).replace_filename("permissions.xml").string(), ca.paths.certificate.string(),
      ca_paths(arguments.text("--ca"), "permissions").certificate.string());
  report.result = {{"file", to.string()}, {"algorithm", to_string(content.key)}};
  report.result.update(describe(certificate));
  return report;
}

const Option kClamp{"--clamp", "", "end with the CA if it ends before"};
const Option kSubject{"--subject", "DN", "the certificate's name, if not CN=NAME"};
const Option kNewFolder{
    .name = "-o", .value = "DIR", .summary = "the new folder", .required = true};

Command issue_row() {
  return {
      .group = "identity",
      .name = "issue",
      .summary = "Makes a participant's folder: key, certificate, CA certificates, permissions.",
      .positionals = {{"NAME", "the participant's name", true}},
      .options = {ca_option("the folder that ca create made"),
                  kNewFolder,
                  kSubject,
                  days("365"),
                  kClamp,
                  kKey,
                  {"--from", "FILE",
                   "a fleet in TOML: [[participant]] with name, publish, "
                   "subscribe, domain, subject, days, key, permissions"},
                  kDomains,
                  repeated("--publish", "TOPIC", "a topic or expression it may publish"),
                  repeated("--subscribe", "TOPIC", "a topic or expression it may subscribe to"),
                  {"--permissions", "FILE", "a permissions document to sign instead"},
                  {"--governance", "FILE", "a signed governance document to copy"},
                  kPassphraseFile,
                  kPassphraseEnv,
                  kInsecureKeyMode},
      .examples = {"ddssec identity issue talker --ca ca -o talker --publish rt/chatter "
                   "--governance governance.p7s",
                   "ddssec identity issue --from participants.toml --ca ca -o fleet "
                   "--governance governance.p7s"},
      .run = identity_issue};
}

}  // namespace

std::vector<Command> identity_commands() {
  return {issue_row(),
          {.group = "identity",
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
                       days("365"),
                       kClamp,
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
