// ca: certificate authorities.
#include <filesystem>
#include <optional>
#include <sys/stat.h>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ca_progress.hpp"
#include "cli/ca/participant_places.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/commands/ca_results.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/passphrase.hpp"
#include "cli/inputs/times.hpp"
#include "cli/participant/participant.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct NewCa {
  std::string role;
  fs::path below;  // the CA's folder inside the new one
};

Result<std::vector<NewCa>> wanted(const std::string& role) {
  if (role == "both")
    return std::vector<NewCa>{{"identity", "identity"}, {"permissions", "permissions"}};
  if (role == "identity" || role == "permissions") return std::vector<NewCa>{{role, ""}};
  return fail(Code::usage,
              {.field = "--role", .expected = "identity, permissions or both", .found = role});
}

std::string subject_of(const Arguments& arguments, const NewCa& ca, const fs::path& folder) {
  if (arguments.has("--subject")) return arguments.text("--subject");
  return ca_subject(folder_name(folder), ca.role == "identity" ? "Identity" : "Permissions");
}

// The common properties of the CAs of one command. `above` is nullptr for roots.
struct CaPlan {
  pki::Validity life;
  const OpenCa* above;
};

Result<pki::Authority> make_ca(const std::string& subject, const pki::PrivateKey& key,
                               const CaPlan& plan, Random& random) {
  return plan.above != nullptr ? plan.above->authority.subordinate(subject, key, plan.life, random)
                               : pki::Authority::create_root(subject, key, plan.life, random);
}

// The CA above a new one. It is named by --intermediate-of, which is the folder of a single CA.
Result<std::optional<OpenCa>> ca_above(const Arguments& arguments, CaOpener& opener) {
  if (!arguments.has("--intermediate-of")) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(auto above,
                          opener.open(ca_paths(arguments.text("--intermediate-of"), "identity")));
  if (above.certificate().path_length() == 0)
    return fail(Code::path_too_long, {.document = above.paths.certificate,
                                      .expected = "a CA that may have CAs below it",
                                      .found = "pathlen 0"});
  return above;
}

Result<Answer<CreatedCas>> ca_create(const Arguments& arguments, const Context& context) {
  const fs::path target = arguments.text("DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto cas, wanted(arguments.text("--role")));
  if (cas.size() > 1 && arguments.has("--subject"))
    return fail(Code::usage, {.field = "--subject", .note = "two CAs need two names"});
  const bool in_token = names_token(arguments.text("--key"));
  if (cas.size() > 1 && in_token)
    return fail(Code::usage,
                {.field = "--key", .note = "two CAs need two keys: make one by one, with --role"});
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(auto life, validity(arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(target));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto above, ca_above(arguments, opener));
  if (above) {
    DDSSEC_ASSIGN_OR_RETURN(life, within_ca(life, above->certificate(), arguments.has("--clamp")));
  }
  std::optional<pki::Passphrase> secret;
  if (!in_token && !arguments.has("--no-passphrase")) {
    DDSSEC_ASSIGN_OR_RETURN(secret, new_passphrase(arguments));
  }

  Answer<CreatedCas> out{{target, secret.has_value(), {}, in_token}};
  std::string log_lines;
  for (const auto& wanted_ca : cas) {
    DDSSEC_ASSIGN_OR_RETURN(const auto key, new_key(arguments));
    DDSSEC_ASSIGN_OR_RETURN(const auto ca,
                            make_ca(subject_of(arguments, wanted_ca, target), key.key,
                                    {life, above ? &*above : nullptr}, context.random));
    const auto trust = ca.certificate().pem() + (above ? above->trust_pem : "");
    DDSSEC_RETURN_IF_ERROR(
        add_ca(folder, ca_paths_in(wanted_ca.below), trust, key, secret ? &*secret : nullptr));
    if (wanted_ca.role == "identity") {
      DDSSEC_ASSIGN_OR_RETURN(const auto list, first_crl(ca));
      DDSSEC_RETURN_IF_ERROR(folder.add_public(ca_paths_in(wanted_ca.below).crl, list.pem()));
    }
    log_lines += pki::IssueLog::issued_line(ca.certificate(), "", now);
    out.result.cas.push_back({CaFacts::of(ca.certificate()), wanted_ca.role});
  }
  if (above) DDSSEC_RETURN_IF_ERROR(log_issued(above->paths, log_lines));
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, folder.commit());
  return out;
}

struct ImportedKey {
  NewKey key;
  std::optional<pki::Passphrase> secret;  // the passphrase that protects the stored key
};

Result<ImportedKey> imported_key(const Arguments& arguments) {
  const auto given = arguments.text("--key");
  if (names_token(given)) {
    DDSSEC_ASSIGN_OR_RETURN(auto private_key, token_key(given, arguments));
    return ImportedKey{{std::move(private_key), given}, std::nullopt};
  }
  std::optional<pki::Passphrase> secret;
  DDSSEC_ASSIGN_OR_RETURN(const auto encrypted, is_encrypted(given));
  const bool is_plain = !encrypted;
  if (!is_plain || !arguments.has("--no-passphrase")) {
    DDSSEC_ASSIGN_OR_RETURN(secret, is_plain ? new_passphrase(arguments) : passphrase(arguments));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto key, read_key(given, secret ? &*secret : nullptr));
  return ImportedKey{{std::move(key)}, std::move(secret)};
}

// Adds the CA to a folder that exists, or creates the folder. Both roles can thus be imported one
// after the other.
Result<Answer<ImportedCa>> ca_import(const Arguments& arguments, const Context&) {
  DDSSEC_ASSIGN_OR_RETURN(const auto role, role_option(arguments));
  const fs::path given = arguments.text("DIR");
  std::error_code ignored;
  const bool exists = fs::is_directory(given, ignored);
  DDSSEC_ASSIGN_OR_RETURN(auto folder, NewFolder::at(exists ? given / role : given));
  const auto names = ca_paths_in(exists ? fs::path() : fs::path(role));
  const fs::path from = arguments.text("--cert");
  DDSSEC_ASSIGN_OR_RETURN(const auto certificates, read_certificates(from));
  const auto& ca = certificates.front();
  if (!ca.is_ca())
    return fail(Code::not_a_ca, {.document = from, .expected = "basicConstraints CA:TRUE"});
  const bool has_key = arguments.has("--key");
  if (has_key) {
    DDSSEC_ASSIGN_OR_RETURN(const auto imported, imported_key(arguments));
    const auto& [key, secret] = imported;
    const bool in_token = !key.token_uri.empty();
    DDSSEC_RETURN_IF_ERROR(with_default_document(
        key.key.check_fits(ca), in_token ? from : fs::path(arguments.text("--key"))));
    DDSSEC_RETURN_IF_ERROR(
        add_ca(folder, names, to_pem(certificates), key, secret ? &*secret : nullptr));
  } else {
    DDSSEC_RETURN_IF_ERROR(folder.add_public(names.certificate, to_pem(certificates)));
  }
  Answer<ImportedCa> out{{CaFacts::of(ca), role, has_key}};
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, folder.commit());
  return out;
}

// Empty if the key is not on this machine.
Result<std::optional<KeyFacts>> key_facts(const fs::path& key) {
  struct stat status {};
  if (::stat(key.c_str(), &status) != 0) return std::nullopt;
  const bool in_token = key.extension() == ".p11";
  bool encrypted = false;
  if (!in_token) {
    DDSSEC_ASSIGN_OR_RETURN(encrypted, is_encrypted(key));
  }
  KeyFacts out{encrypted, fmt::format("{:04o}", status.st_mode & 07777)};
  if (in_token) {
    DDSSEC_ASSIGN_OR_RETURN(const auto uri, pki::uri_of(key));
    out.token = without_pin(uri);
  }
  return out;
}

// `role` is empty if the folder does not show the CA's role.
Result<ShownCa> show_one(const CaPaths& paths, std::optional<std::string> role, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(auto key, key_facts(paths.key));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, present_crl(paths));
  const auto left =
      std::chrono::floor<std::chrono::days>(std::max(certificate.not_after() - now, {}));
  ShownCa out{.role = std::move(role),
              .ca = CaFacts::of(certificate),
              .is_ca = certificate.is_ca(),
              .key = std::move(key),
              .issued = log.issued().size(),
              .revoked = log.revocations().size(),
              .crl = {},
              .days_left = count_text(static_cast<std::size_t>(left.count()), "day")};
  if (crl) out.crl = ListFacts{ListNumber::of(*crl), crl->next_update()};
  return out;
}

// True if the folder belongs to a single CA, or one CA has both roles.
bool is_one_ca(const fs::path& given) {
  std::error_code ignored;
  return fs::equivalent(ca_paths(given, "identity").certificate,
                        ca_paths(given, "permissions").certificate, ignored);
}

// The role that --role names, or all roles in the folder.
Result<std::vector<std::string>> shown_roles(const Arguments& arguments) {
  std::vector<std::string> out;
  if (arguments.has("--role")) {
    DDSSEC_ASSIGN_OR_RETURN(auto wanted_role, role_option(arguments));
    out.push_back(std::move(wanted_role));
    return out;
  }
  const fs::path given = arguments.text("DIR");
  for (const auto* role : {"identity", "permissions"})
    if (check_ca_folder(given, role)) out.emplace_back(role);
  if (out.empty() || is_one_ca(given)) out = {"identity"};
  return out;
}

Result<Answer<ShownCas>> ca_show(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto roles, shown_roles(arguments));
  const fs::path given = arguments.text("DIR");
  const auto now = context.clock.calendar_seconds();
  std::optional<Answer<ShownCas>> out;
  std::vector<Error> errors;
  for (const auto& role : roles) {
    DDSSEC_RETURN_IF_ERROR(check_ca_folder(given, role));
    const auto paths = ca_paths(given, role);
    auto shown_role = is_one_ca(given) ? std::nullopt : std::optional(role);
    DDSSEC_ASSIGN_OR_RETURN(auto one, show_one(paths, std::move(shown_role), now));
    DDSSEC_ASSIGN_OR_RETURN(one.rotation, shown_rotation(given, role, now));
    if (!one.is_ca)
      errors.emplace_back(Code::not_a_ca, ErrorDetails{.document = paths.certificate});
    if (out)
      out->result.others.push_back(std::move(one));
    else
      out = Answer<ShownCas>{{std::move(one)}};
  }
  if (!errors.empty()) out->report.exit = Exit::no;
  out->report.errors = std::move(errors);
  return *std::move(out);
}

// The present certificate stays in the file after the new one as long as it is valid, so that the
// signer of existing documents is still listed.
std::string renewed_trust(const pki::Certificate& renewed, const std::string& before) {
  return renewed.pem() + before;
}

Result<pki::Certificate> renewed_ca(const OpenCa& ca, pki::Validity life,
                                    const Arguments& arguments, const Context& context) {
  if (ca.certificate().is_self_issued()) return ca.authority.renewed(life, context.random);
  if (!arguments.has("--issuer"))
    return fail(Code::usage, {.field = "--issuer",
                              .note = "the CA is an intermediate one: the CA above it must sign"});
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto above,
                          opener.open(ca_paths(arguments.text("--issuer"), "identity")));
  DDSSEC_ASSIGN_OR_RETURN(const auto within,
                          within_ca(life, above.certificate(), arguments.has("--clamp")));
  DDSSEC_ASSIGN_OR_RETURN(auto out,
                          above.authority.reissue(ca.certificate(), within, context.random));
  DDSSEC_RETURN_IF_ERROR(log_issued(
      above.paths, pki::IssueLog::issued_line(out, "", context.clock.calendar_seconds())));
  return out;
}

// The next steps, in order. A document contains its signer's certificate and is verified with it.
// ddssec accepts every certificate of the file, stock products only the first (measured).
std::string steps_for_permissions(const OpenCa& ca, const std::string& given, WallTime now) {
  const auto end = ca.certificate().not_after();
  const bool is_keystore = path_exists(fs::path(given) / "public/permissions_ca.cert.pem");
  return fmt::format(
      "The signed documents are still the old certificate's, which {} on {}. {}:\n"
      "  with ddssec's plugins alone: put the new {} into every folder as permissions_ca.pem; then "
      "sign governance and permissions again\n"
      "  with stock Cyclone DDS or Fast DDS anywhere: they refuse documents of the old certificate "
      "as soon as the new file is in the folder, and new documents before. Sign all governance and "
      "permissions again, put them and the new file into all folders together, and start all "
      "participants again. One command does that, with a new key: ddssec {} rotate {} --role "
      "permissions\n",
      end > now ? "ends" : "ended", date(end), end > now ? "Before that day" : "Now",
      ca.paths.certificate.filename().string(), is_keystore ? "keystore" : "ca", shell_word(given));
}

Result<std::string> steps_after_renewal(const OpenCa& ca, const std::string& role,
                                        const std::string& given, WallTime now) {
  if (role == "permissions") return steps_for_permissions(ca, given, now);
  const auto end = ca.certificate().not_after();
  std::string out = "Participants take the new and the old certificate. ";
  out += path_exists(fs::path(given) / "public/identity_ca.cert.pem")
             ? "Enclaves of the keystore have a link to the new one.\n"
             : fmt::format("Put the new {} into every folder as identity_ca.pem {}.\n",
                           ca.paths.certificate.filename().string(),
                           end > now ? "before " + date(end) : "now");
  DDSSEC_ASSIGN_OR_RETURN(const auto list, present_crl(ca.paths));
  if (list && list->next_update() && *list->next_update() <= end)
    out += fmt::format(
        "The revocation list {} on {}; from then on no new peer is authenticated. {}: ddssec crl "
        "new --ca {}, then ddssec crl distribute --ca {}\n",
        *list->next_update() > now ? "ends" : "ended", date(*list->next_update()),
        *list->next_update() > now ? "Before that day" : "Now", shell_word(given),
        shell_word(given));
  return out;
}

Result<Answer<RenewedCa>> ca_renew(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto role, role_option(arguments));
  CaOpener opener(arguments);
  DDSSEC_RETURN_IF_ERROR(check_ca_folder(arguments.text("DIR"), role));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open(ca_paths(arguments.text("DIR"), role)));
  DDSSEC_ASSIGN_OR_RETURN(const auto life, validity(arguments, context.clock.calendar_seconds()));
  DDSSEC_ASSIGN_OR_RETURN(const auto renewed, renewed_ca(ca, life, arguments, context));
  FileTransaction files;
  DDSSEC_RETURN_IF_ERROR(
      files.put_public(ca.paths.certificate, renewed_trust(renewed, ca.trust_pem)));
  DDSSEC_ASSIGN_OR_RETURN(auto steps, steps_after_renewal(ca, role, arguments.text("DIR"),
                                                          context.clock.calendar_seconds()));
  Answer<RenewedCa> out{
      {.ca = CaFacts::of(renewed), .dir = arguments.text("DIR"), .steps = std::move(steps)}};
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca.paths));
  const LoggedFolders folders(ca.paths, log);
  for (const auto& logged : log.places())
    out.result.folders.push_back(folders.today(logged).string());
  DDSSEC_ASSIGN_OR_RETURN(out.report.files_written, files.commit());
  return out;
}

const Option kOneRole{"--role", "ROLE", "identity or permissions, where DIR has both", "identity"};
const Option kClamp{"--clamp", "", "end with the CA above if it ends before"};

}  // namespace

std::vector<Command> ca_commands() {
  return {{.group = "ca",
           .name = "create",
           .summary = "Makes an identity CA and a permissions CA, with encrypted keys.",
           .positionals = {{"DIR", "a new folder"}},
           .options = {{"--role", "ROLE", "identity, permissions or both", "both"},
                       {"--subject", "DN", "the CA's name, such as \"CN=Plant CA,O=Example\""},
                       days("3650"),
                       kKeyOrToken,
                       {"--intermediate-of", "DIR", "the CA that issues it; without it, a root"},
                       kClamp,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kNoPassphrase,
                       kInsecureKeyMode},
           .examples = {"ddssec ca create ca --passphrase-file passphrase.txt",
                        "ddssec ca create test-ca --no-passphrase",
                        "ddssec ca create plant --role identity --intermediate-of ca/identity "
                        "--passphrase-file passphrase.txt"},
           .run = ca_create},
          {.group = "ca",
           .name = "import",
           .summary = "Takes over a CA that was made elsewhere.",
           .positionals = {{"DIR", "a new folder, or one that has the other role"}},
           .options = {kOneRole,
                       {.name = "--cert",
                        .value = "FILE",
                        .summary = "its certificate, and behind it those of the CAs above it",
                        .required = true},
                       {"--key", "FILE",
                        "its private key, or the pkcs11: URI of one in a token; without it, it "
                        "cannot issue here"},
                       kPassphraseFile,
                       kPassphraseEnv,
                       kNoPassphrase},
           .examples = {"ddssec ca import ca --cert plant.pem --key plant.key "
                        "--passphrase-file passphrase.txt"},
           .run = ca_import},
          {.group = "ca",
           .name = "show",
           .summary = "Shows a CA's name, validity, how its key is kept and what it issued.",
           .positionals = {{"DIR", "the CA's folder, or one with both"}},
           .options = {{"--role", "ROLE", "identity or permissions; without it, both"}},
           .examples = {"ddssec ca show ca/identity", "ddssec ca show ca --role permissions"},
           .run = ca_show},
          {.group = "ca",
           .name = "renew",
           .summary = "Gives a CA a certificate with a new validity, for the same key and name.",
           .positionals = {{"DIR", "the CA's folder, or one with both"}},
           .options = {kOneRole,
                       days("3650"),
                       {"--issuer", "DIR", "the CA above, for an intermediate one"},
                       kClamp,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec ca renew ca --role permissions --days 3650"},
           .run = ca_renew}};
}

}  // namespace ddssec::cli
