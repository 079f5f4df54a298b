// keystore split-ca, keystore rotate: new CAs for a keystore that is in use, and everything signed
// anew.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/keystore.hpp"
#include "cli/options.hpp"
#include "cli/transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using Links = Replacement::Links;

bool is_plain_file(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::regular;
}

// Upstream links both roles to one CA.
bool has_one_ca(const fs::path& keystore) {
  std::error_code ignored;
  return fs::equivalent(keystore / "private/identity_ca.key.pem",
                        keystore / "private/permissions_ca.key.pem", ignored);
}

Status put_ca(Replacement& out, const CaPaths& paths, const pki::Authority& ca,
              const pki::Passphrase* passphrase) {
  const auto pem = DDSSEC_TRY(ca.key().to_pem(passphrase));
  DDSSEC_TRY(pem.expose(
      [&](BytesView octets) { return out.put(paths.key, octets, 0600, Links::replaced); }));
  return out.put(paths.certificate, as_bytes(ca.certificate().pem()), 0644, Links::replaced);
}

/// Who signed until now, who signs from now on.
struct Change {
  fs::path old_ca;
  const pki::Authority& now_signs;
  const Context& context;
};

// Only what the old CA signed is signed by the new one.
Result<Bytes> signed_anew(const fs::path& file, const Change& change) {
  const auto now = change.context.clock.now();
  const auto proof = DDSSEC_TRY(verified(file, change.old_ca, now));
  std::string text(as_text(proof.content()));
  std::erase(text, '\r');
  return change.now_signs.sign_document(as_bytes(text), now, change.context.random);
}

Status put_signed_anew(Replacement& out, const fs::path& file, const Change& change) {
  return out.put(file, DDSSEC_TRY(signed_anew(file, change)), 0644);
}

// An enclave that was copied has files where there would be links.
Status put_enclave(Replacement& out, const fs::path& folder, const Change& change) {
  const auto files = pki::participant_folder(folder, pki::FolderLayout::sros2);
  DDSSEC_TRY(put_signed_anew(out, files.permissions, change));
  if (is_plain_file(files.permissions_ca))
    DDSSEC_TRY(out.put_public(files.permissions_ca, change.now_signs.certificate().pem()));
  if (is_plain_file(files.governance) && folder.filename() != "enclaves")
    DDSSEC_TRY(put_signed_anew(out, files.governance, change));
  return {};
}

pki::Validity life_like(const pki::Certificate& old, WallTime now) {
  return {now - kBackdated, now + (old.not_after() - old.not_before())};
}

Report report_of(const fs::path& keystore, std::string_view role, const pki::Certificate& ca,
                 const std::vector<std::string>& enclaves) {
  Report report;
  report.text = fmt::format(
      "{}  {} CA is {} now; {} signed anew\nEvery participant must start again with the new "
      "files.\n",
      keystore.string(), role, ca.subject(), counted(enclaves.size(), "enclave"));
  report.result = {{"role", role},
                   {"subject", ca.subject()},
                   {"not_after", to_string(ca.not_after())},
                   {"sha256", to_hex(ca.fingerprint())},
                   {"enclaves", enclaves}};
  return report;
}

std::string subject_for(const fs::path& keystore, std::string_view role) {
  std::error_code ignored;
  return fmt::format("CN={} {} CA",
                     fs::absolute(keystore, ignored).lexically_normal().filename().string(), role);
}

Result<Report> new_permissions_ca(const fs::path& keystore, const std::string& subject,
                                  const Arguments& arguments, const Context& context) {
  const auto paths = ca_paths(keystore, "permissions");
  CaOpener opener(arguments);
  const auto old = DDSSEC_TRY(opener.open(paths));
  const auto ca = DDSSEC_TRY(pki::Authority::create_root(
      subject, {}, life_like(old.certificate(), context.clock.now()), context.random));
  const Change change{paths.certificate, ca, context};
  const auto enclaves = enclaves_of(keystore);
  Replacement out;
  DDSSEC_TRY(put_ca(out, paths, ca, opener.used_passphrase()));
  DDSSEC_TRY(put_signed_anew(out, keystore / "enclaves/governance.p7s", change));
  for (const auto& name : enclaves)
    DDSSEC_TRY(put_enclave(out, keystore / enclave_folder(name), change));
  auto report = report_of(keystore, "permissions", ca.certificate(), enclaves);
  report.files_written = DDSSEC_TRY(out.commit());
  return report;
}

Result<Report> new_identity_ca(const fs::path& keystore, const Arguments& arguments,
                               const Context& context) {
  const auto paths = ca_paths(keystore, "identity");
  const auto now = context.clock.now();
  CaOpener opener(arguments);
  const auto old = DDSSEC_TRY(opener.open(paths));
  auto authority = DDSSEC_TRY(pki::Authority::create_root(
      old.certificate().subject(), {}, life_like(old.certificate(), now), context.random));
  const auto enclaves = enclaves_of(keystore);
  const auto lock = DDSSEC_TRY(lock_records(paths));
  const auto log = DDSSEC_TRY(read_issue_log(paths));
  const auto crl =
      DDSSEC_TRY(next_crl({paths, authority, authority.certificate().pem()}, log, now, 180));
  Replacement out;
  DDSSEC_TRY(put_ca(out, paths, authority, opener.used_passphrase()));
  DDSSEC_TRY(out.put_public(paths.crl, crl.pem()));
  std::string lines;
  std::vector<std::string> again_in, left_out;
  for (const auto& name : enclaves) {
    const auto folder = keystore / enclave_folder(name);
    const auto certificate = DDSSEC_TRY(read_certificate(folder / "cert.pem"));
    if (!certificate.is_issued_by(old.certificate()))
      return fail(Code::issuer_unknown, {.document = folder / "cert.pem",
                                         .expected = "one that the old CA issued",
                                         .found = "one of " + certificate.issuer()});
    if (log.is_revoked(certificate.serial())) {
      left_out.push_back(name);
      continue;
    }
    again_in.push_back(name);
    const auto again = DDSSEC_TRY(authority.reissue(
        certificate, {now - kBackdated, certificate.not_after()}, context.random));
    DDSSEC_TRY(out.put_public(folder / "cert.pem", again.pem()));
    if (is_plain_file(folder / "identity_ca.cert.pem"))
      DDSSEC_TRY(out.put_public(folder / "identity_ca.cert.pem", authority.certificate().pem()));
    if (is_plain_file(folder / "crl.pem"))  // the old CA's list would shut everybody out
      DDSSEC_TRY(out.put_public(folder / "crl.pem", crl.pem()));
    std::error_code ignored;
    lines += pki::IssueLog::issued_line(
        again, fs::absolute(folder, ignored).lexically_normal().string(), now);
  }
  DDSSEC_TRY(check_not_interrupted());
  DDSSEC_TRY(append_lines(paths.log, lines));
  auto report = report_of(keystore, "identity", authority.certificate(), again_in);
  for (const auto& name : left_out) report.text += name + " is revoked and was left out\n";
  report.files_written = DDSSEC_TRY(out.commit());
  return report;
}

Result<Report> keystore_split_ca(const Arguments& arguments, const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_TRY(check_keystore(keystore));
  if (!has_one_ca(keystore)) {
    const auto ca = DDSSEC_TRY(read_certificate(ca_paths(keystore, "permissions").certificate));
    auto report = report_of(keystore, "permissions", ca, {});
    report.text = fmt::format("{}  has two CAs already\n", keystore.string());
    return report;
  }
  return new_permissions_ca(keystore, subject_for(keystore, "Permissions"), arguments, context);
}

Result<Report> keystore_rotate(const Arguments& arguments, const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_TRY(check_keystore(keystore));
  const auto role = arguments.text("--role");
  if (role != "identity" && role != "permissions")
    return fail(Code::usage,
                {.field = "--role", .expected = "identity or permissions", .found = role});
  if (has_one_ca(keystore))
    return fail(Code::usage, {.field = "KEYSTORE",
                              .note = "it has one CA for both: ddssec keystore split-ca first"});
  if (role == "identity") return new_identity_ca(keystore, arguments, context);
  const auto ca = DDSSEC_TRY(read_certificate(ca_paths(keystore, "permissions").certificate));
  return new_permissions_ca(keystore, ca.subject(), arguments, context);
}

}  // namespace

std::vector<Command> keystore_ca_commands() {
  return {{.group = "keystore",
           .name = "split-ca",
           .summary = "Gives a keystore with one CA a permissions CA of its own; signs all anew.",
           .positionals = {{"KEYSTORE", "the keystore's folder"}},
           .options = {kPassphraseFile, kPassphraseEnv, kInsecureKeyMode},
           .examples = {"ddssec keystore split-ca keystore"},
           .run = keystore_split_ca},
          {.group = "keystore",
           .name = "rotate",
           .summary = "Replaces a CA and its key; issues or signs everything of it anew.",
           .positionals = {{"KEYSTORE", "the keystore's folder"}},
           .options = {{.name = "--role",
                        .value = "ROLE",
                        .summary = "identity or permissions",
                        .required = true},
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec keystore rotate keystore --role permissions"},
           .run = keystore_rotate}};
}

}  // namespace ddssec::cli
