// identity: a participant's key, certificate and permissions.
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/transaction.hpp"
#include "governance/model.hpp"
#include "governance/write.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// A certificate that outlives its CA would stop being believed before it says so.
Result<pki::Validity> within(pki::Validity wanted, const pki::Certificate& ca, bool clamp) {
  if (wanted.not_after > ca.not_after()) {
    if (!clamp)
      return fail(Code::outlives_ca, {.expected = "an end before " + to_string(ca.not_after()),
                                      .found = to_string(wanted.not_after)});
    wanted.not_after = ca.not_after();
  }
  wanted.not_before = std::max(wanted.not_before, ca.not_before());
  return wanted;
}

std::vector<governance::Text> texts(const std::vector<std::string>& expressions) {
  std::vector<governance::Text> out;
  for (const auto& expression : expressions) out.push_back({expression, 0});
  return out;
}

// One grant with one allow rule: the subject is the certificate's own text, the form that every
// vendor reads.
std::string permissions_for(const pki::Certificate& certificate, DomainId domain,
                            const Arguments& arguments) {
  governance::Rule rule{.allow = true, .domains = {.ranges = {{domain, domain}}}};
  const auto publish = texts(arguments.all("--publish"));
  const auto subscribe = texts(arguments.all("--subscribe"));
  if (!publish.empty()) rule.publish.push_back({.topics = publish});
  if (!subscribe.empty()) rule.subscribe.push_back({.topics = subscribe});
  governance::Grant grant{.name = "participant",
                          .subject_name = certificate.subject(),
                          .validity = {certificate.not_before(), certificate.not_after()}};
  grant.rules.push_back(std::move(rule));
  return to_xml(governance::Permissions{.grants = {std::move(grant)}});
}

bool has_rights(const Arguments& arguments) {
  return arguments.has("--publish") || arguments.has("--subscribe");
}

Status add_permissions(NewFolder& folder, const pki::Certificate& certificate,
                       const Arguments& arguments, const Context& context) {
  const auto domain = DDSSEC_TRY(arguments.number("--domain", 0, governance::kHighestDomainId));
  const auto ca = DDSSEC_TRY(load_ca(ca_folder(arguments.text("--ca"), "permissions"), arguments));
  const auto xml = permissions_for(certificate, static_cast<DomainId>(domain), arguments);
  const auto document =
      DDSSEC_TRY(ca.sign_document(as_bytes(xml), context.clock.now(), context.random));
  DDSSEC_TRY(folder.add_public("permissions_ca.pem", ca.certificate().pem()));
  return folder.add("permissions.p7s", document, 0644);
}

Status add_governance(NewFolder& folder, const Arguments& arguments) {
  if (!arguments.has("--governance")) return {};
  const auto octets =
      DDSSEC_TRY(read_file(arguments.text("--governance"), pki::kMostDocumentOctets));
  return folder.add("governance.p7s", octets, 0644);
}

Status add_identity(NewFolder& folder, const pki::Credential& self, const pki::Certificate& ca) {
  DDSSEC_TRY(folder.add_public("identity_ca.pem", ca.pem()));
  DDSSEC_TRY(folder.add_public("cert.pem", self.certificate.pem()));
  const auto pem = DDSSEC_TRY(self.key.to_pem());
  return pem.expose([&](BytesView octets) { return folder.add("key.pem", octets, 0600); });
}

fs::path certificate_path(const fs::path& given) {
  std::error_code ignored;
  return fs::is_directory(given, ignored) ? given / "cert.pem" : given;
}

Result<Report> identity_issue(const Arguments& arguments, const Context& context) {
  const auto name = arguments.text("NAME");
  DDSSEC_TRY(check_name(name));
  const auto wanted = DDSSEC_TRY(validity(arguments, context.clock.now()));
  const auto spec = DDSSEC_TRY(key_spec(arguments));
  const fs::path target = arguments.text("-o");
  auto folder = DDSSEC_TRY(NewFolder::at(target));
  const auto ca = DDSSEC_TRY(load_ca(ca_folder(arguments.text("--ca"), "identity"), arguments));
  const auto life = DDSSEC_TRY(within(wanted, ca.certificate(), arguments.has("--clamp")));
  const auto subject = arguments.has("--subject") ? arguments.text("--subject") : "CN=" + name;
  const auto self = DDSSEC_TRY(ca.issue(subject, spec, life, context.random));
  DDSSEC_TRY(add_identity(folder, self, ca.certificate()));
  if (has_rights(arguments))
    DDSSEC_TRY(add_permissions(folder, self.certificate, arguments, context));
  DDSSEC_TRY(add_governance(folder, arguments));

  Report report;
  report.text = fmt::format("{}  {}  expires {}\n", target.string(), self.certificate.subject(),
                            date(self.certificate.not_after()));
  report.result = {{"name", name},
                   {"dir", target.string()},
                   {"subject", self.certificate.subject()},
                   {"serial", self.certificate.serial()},
                   {"not_after", to_string(self.certificate.not_after())},
                   {"sha256", to_hex(self.certificate.fingerprint())}};
  report.files_written = DDSSEC_TRY(folder.commit());
  return report;
}

Result<Report> identity_show(const Arguments& arguments, const Context& context) {
  const auto path = certificate_path(arguments.text("PATH"));
  const auto certificate = DDSSEC_TRY(read_certificate(path));
  const auto now = context.clock.now();
  const bool valid = certificate.not_before() <= now && now <= certificate.not_after();
  Report report;
  report.exit = valid ? Exit::done : Exit::no;
  report.text = fmt::format(
      "subject  {}\nissuer   {}\nkey      {}\nserial   {}\nvalid    {} .. {}\nsha256   {}\n",
      certificate.subject(), certificate.issuer(), to_string(certificate.key_algorithm()),
      certificate.serial(), date(certificate.not_before()), date(certificate.not_after()),
      to_hex(certificate.fingerprint()));
  report.result = {{"subject", certificate.subject()},
                   {"issuer", certificate.issuer()},
                   {"algorithm", to_string(certificate.key_algorithm())},
                   {"serial", certificate.serial()},
                   {"not_before", to_string(certificate.not_before())},
                   {"not_after", to_string(certificate.not_after())},
                   {"valid_now", valid},
                   {"sha256", to_hex(certificate.fingerprint())}};
  if (!valid)
    report.errors.emplace_back(now < certificate.not_before() ? Code::certificate_not_yet_valid
                                                              : Code::certificate_expired,
                               ErrorDetails{.document = path, .found = to_string(now)});
  return report;
}

}  // namespace

std::vector<Command> identity_commands() {
  return {
      {.group = "identity",
       .name = "issue",
       .summary = "Makes a participant's folder: key, certificate, CA certificates, permissions.",
       .positionals = {{"NAME", "the participant's name"}},
       .options = {ca_option("the folder that ca create made"),
                   {.name = "-o", .value = "DIR", .summary = "the new folder", .required = true},
                   {"--subject", "DN", "the certificate's name, if not CN=NAME"},
                   days("365"),
                   {"--clamp", "", "end with the CA if it ends before"},
                   kKey,
                   {"--domain", "N", "the domain of the permissions", "0"},
                   repeated("--publish", "TOPIC", "a topic or expression it may publish"),
                   repeated("--subscribe", "TOPIC", "a topic or expression it may subscribe to"),
                   {"--governance", "FILE", "a signed governance document to copy"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity issue talker --ca ca -o talker --publish rt/chatter "
                    "--governance governance.p7s"},
       .run = identity_issue},
      {.group = "identity",
       .name = "show",
       .summary = "Shows a certificate; exit 1 if it is not valid now.",
       .positionals = {{"PATH", "a participant's folder or a certificate"}},
       .options = {},
       .examples = {"ddssec identity show talker"},
       .run = identity_show}};
}

}  // namespace ddssec::cli
