// ca: certificate authorities.
#include <filesystem>
#include <optional>
#include <sys/stat.h>

#include <fmt/format.h>

#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct NewCa {
  std::string role;
  fs::path below;  ///< inside the new folder
};

Result<std::vector<NewCa>> wanted(const std::string& role) {
  if (role == "both")
    return std::vector<NewCa>{{"identity", "identity"}, {"permissions", "permissions"}};
  if (role == "identity" || role == "permissions") return std::vector<NewCa>{{role, ""}};
  return fail(Code::usage,
              {.field = "--role", .expected = "identity, permissions or both", .found = role});
}

// One CA below the roots at most: a root with pathlen 1 allows an intermediate.
Result<pki::Authority> make_root(const std::string& subject, pki::KeySpec spec,
                                 pki::Validity validity, Random& random) {
  auto root = DDSSEC_TRY(pki::Authority::self_sign(
      {.subject = subject,
       .validity = validity,
       .is_ca = true,
       .path_length = 1,
       .key_usage = std::string(pki::kCaKeyUsage)},
      DDSSEC_TRY(pki::PrivateKey::generate(spec.kind, spec.bits)), random));
  return pki::Authority::load(std::move(root.certificate), std::move(root.key));
}

Json describe(const pki::Certificate& certificate) {
  return {{"subject", certificate.subject()},
          {"algorithm", to_string(certificate.key_algorithm())},
          {"not_before", to_string(certificate.not_before())},
          {"not_after", to_string(certificate.not_after())},
          {"sha256", to_hex(certificate.fingerprint())}};
}

Status add_ca(NewFolder& folder, const fs::path& below, const pki::Authority& ca,
              const pki::Passphrase* passphrase) {
  DDSSEC_TRY(folder.add_public(below / "ca.pem", ca.certificate().pem()));
  const auto pem = DDSSEC_TRY(ca.key().to_pem(passphrase));
  return pem.expose(
      [&](BytesView octets) { return folder.add(below / "ca.key.pem", octets, 0600); });
}

std::string subject_of(const Arguments& arguments, const NewCa& ca, const fs::path& folder) {
  if (arguments.has("--subject")) return arguments.text("--subject");
  const auto name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  return fmt::format("CN={} {} CA", name, ca.role == "identity" ? "Identity" : "Permissions");
}

Result<Report> ca_create(const Arguments& arguments, const Context& context) {
  const fs::path target = arguments.text("DIR");
  const auto cas = DDSSEC_TRY(wanted(arguments.text("--role")));
  if (cas.size() > 1 && arguments.has("--subject"))
    return fail(Code::usage, {.field = "--subject", .note = "two CAs need two names"});
  const auto life = DDSSEC_TRY(validity(arguments, context.clock.now()));
  const auto spec = DDSSEC_TRY(key_spec(arguments));
  auto folder = DDSSEC_TRY(NewFolder::at(target));
  std::optional<pki::Passphrase> secret;
  if (!arguments.has("--no-passphrase")) secret = DDSSEC_TRY(passphrase(arguments, Typed::twice));

  Report report;
  report.text = fmt::format("created {}{}\n", target.string(),
                            secret ? "" : "  (the CA keys are NOT encrypted)");
  report.result = {{"dir", target.string()}, {"encrypted", secret.has_value()}};
  report.result["cas"] = Json::array();
  for (const auto& wanted_ca : cas) {
    const auto ca =
        DDSSEC_TRY(make_root(subject_of(arguments, wanted_ca, target), spec, life, context.random));
    DDSSEC_TRY(add_ca(folder, wanted_ca.below, ca, secret ? &*secret : nullptr));
    report.text += fmt::format("  {:<12} {}  expires {}\n", wanted_ca.role,
                               ca.certificate().subject(), date(ca.certificate().not_after()));
    auto row = describe(ca.certificate());
    row["role"] = wanted_ca.role;
    report.result["cas"].push_back(std::move(row));
  }
  report.files_written = DDSSEC_TRY(folder.commit());
  return report;
}

Result<Report> ca_show(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("DIR");
  const auto certificate = DDSSEC_TRY(read_certificate(folder / "ca.pem"));
  const auto key = folder / "ca.key.pem";
  struct stat status {};
  const bool has_key = ::stat(key.c_str(), &status) == 0;
  const bool encrypted = has_key && DDSSEC_TRY(is_encrypted(key));
  const auto mode = fmt::format("{:04o}", status.st_mode & 07777);
  const auto left =
      std::chrono::floor<std::chrono::days>(certificate.not_after() - context.clock.now());
  Report report;
  report.result = describe(certificate);
  report.result["is_ca"] = certificate.is_ca();
  report.result["key"] = has_key ? Json{{"encrypted", encrypted}, {"mode", mode}} : Json();
  report.text = fmt::format(
      "subject  {}\nkey      {}, {}\nvalid    {} .. {}  ({} days left)\nsha256   {}\n",
      certificate.subject(), to_string(certificate.key_algorithm()),
      !has_key ? "not here"
               : fmt::format("{}, mode {}", encrypted ? "encrypted" : "NOT encrypted", mode),
      date(certificate.not_before()), date(certificate.not_after()), left.count(),
      to_hex(certificate.fingerprint()));
  if (certificate.is_ca()) return report;
  report.exit = Exit::no;
  report.errors.emplace_back(Code::not_a_ca, ErrorDetails{.document = folder / "ca.pem"});
  return report;
}

}  // namespace

std::vector<Command> ca_commands() {
  return {{.group = "ca",
           .name = "create",
           .summary = "Makes an identity CA and a permissions CA, with encrypted keys.",
           .positionals = {{"DIR", "a new folder"}},
           .options = {{"--role", "ROLE", "identity, permissions or both", "both"},
                       {"--subject", "DN", "the CA's name, such as \"CN=Plant CA,O=Example\""},
                       days("3650"),
                       kKey,
                       kPassphraseFile,
                       kPassphraseEnv,
                       {"--no-passphrase", "", "leave the keys unencrypted"}},
           .examples = {"ddssec ca create ca --passphrase-file passphrase.txt",
                        "ddssec ca create test-ca --no-passphrase"},
           .run = ca_create},
          {.group = "ca",
           .name = "show",
           .summary = "Shows a CA's name, validity and how its key is kept.",
           .positionals = {{"DIR", "the folder with ca.pem"}},
           .options = {},
           .examples = {"ddssec ca show ca/identity"},
           .run = ca_show}};
}

}  // namespace ddssec::cli
