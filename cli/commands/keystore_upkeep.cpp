#include "cli/commands/keystore_upkeep.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/doctor/doctor_options.hpp"
#include "cli/doctor/products.hpp"
#include "cli/doctor/renewal_list_check.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"
#include "cli/participant/keystore.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/lint_checks.hpp"
#include "governance/doctor/ros_environment.hpp"
#include "governance/doctor/writable_places.hpp"
#include "pki/certificate_source.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

// Every private key of a keystore that is a file and not a link.
std::vector<fs::path> private_keys(const fs::path& keystore, const Enclaves& enclaves) {
  std::vector<fs::path> out;
  std::error_code ignored;
  for (const auto* name : {"ca.key.pem", "identity_ca.key.pem", "permissions_ca.key.pem"})
    if (fs::symlink_status(keystore / "private" / name, ignored).type() == fs::file_type::regular)
      out.push_back(keystore / "private" / name);
  for (const auto& enclave : enclaves.names) {
    const auto key = keystore / enclave_folder(enclave) / "key.pem";
    if (fs::symlink_status(key, ignored).type() == fs::file_type::regular) out.push_back(key);
  }
  return out;
}

bool is_for_others(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0;
}

// Reports findings that apply to every enclave only once.
void add_once(const std::vector<Finding>& findings, Report& report) {
  for (const auto& finding : findings)
    if (std::ranges::find(report.findings, finding.message, &Finding::message) ==
        report.findings.end())
      report.findings.push_back(finding);
}

// An enclave that was copied from another keystore is valid in itself, but does not belong here.
void diagnose_belongs(const fs::path& keystore, const doctor::LoadedFolder& enclave,
                      const std::string& name, Report& report) {
  const auto differs = [&](const fs::path& file, const fs::path& ours) {
    report.exit = Exit::no;
    report.findings.push_back(
        {.rule = Rule::DOC006,
         .message = fmt::format("{} of enclave {} is not the keystore's {}",
                                file.filename().string(), name, ours.string()),
         .document = file.string()});
  };
  const auto compare_cas = [&](const Result<std::vector<pki::Certificate>>& cas,
                               const fs::path& file, std::string_view role) {
    const auto ours = ca_paths(keystore, role).certificate;
    const auto expected = read_certificates(ours);
    if (cas && expected && to_pem(*cas) != to_pem(*expected)) differs(file, ours);
  };
  compare_cas(enclave.identity_cas, enclave.paths.identity_ca, "identity");
  compare_cas(enclave.permissions_cas, enclave.paths.permissions_ca, "permissions");
  const auto governance = keystore / "enclaves/governance.p7s";
  const auto expected = read_file(governance, pki::kMaxDocumentOctets);
  if (enclave.governance.readable && expected && enclave.governance.file != *expected)
    differs(enclave.paths.governance, governance);
}

// Finds enclaves that have the key of another one. Each of them is valid in itself.
class KeyCopies {
 public:
  explicit KeyCopies(const fs::path& keystore)
      : keystore_(keystore),
        paths_(ca_paths(keystore, "identity")),
        log_(read_issue_log(paths_).value_or(pki::IssueLog())) {}

  void add(const doctor::LoadedFolder& enclave, const std::string& name, Report& report) {
    if (!enclave.certificate) return;
    const auto& certificate = *enclave.certificate;
    const KeyHolder one{name, enclave.paths.certificate.string(), is_at_home(enclave, name)};
    const auto [at, is_new] = enclave_of_key_.try_emplace(pki::key_digest(certificate), one);
    if (is_new) return;
    const bool is_original = one.is_at_home && !at->second.is_at_home;
    const auto original = is_original ? one : at->second;
    const auto copy = is_original ? at->second : one;
    at->second = original;
    report.exit = Exit::no;
    report.findings.push_back(
        {.rule = Rule::DOC006,
         .message = fmt::format("enclave {} has the key of enclave {}, \"{}\": it is a copy",
                                copy.name, original.name, certificate.subject()),
         .document = copy.certificate,
         .hint = hint_for(copy.name)});
  }

 private:
  struct KeyHolder {
    std::string name, certificate;
    bool is_at_home;  // the certificate was issued for this enclave
  };

  bool is_at_home(const doctor::LoadedFolder& enclave, const std::string& name) const {
    const auto& certificate = *enclave.certificate;
    const auto log_status = log_status_of(certificate, enclave.paths.folder, paths_, log_);
    return log_status == LogStatus::own ||
           (log_status == LogStatus::unlogged && certificate.subject() == "CN=" + name);
  }

  std::string hint_for(const std::string& name) const {
    if (name == "/")
      return fmt::format(
          "move cert.pem, key.pem and permissions.p7s out of {}, the folder of all enclaves",
          (keystore_ / "enclaves").string());
    return fmt::format(
        "ddssec keystore enclave {} {} --replace, with its rights (--publish, --subscribe or "
        "--policy), gives it a key of its own",
        shell_word(keystore_.string()), shell_word(name));
  }

  fs::path keystore_;
  CaPaths paths_;
  pki::IssueLog log_;
  std::map<std::string, KeyHolder> enclave_of_key_ = {};
};

void refuse(Rule rule, const fs::path& file, std::string message, Report& report) {
  report.exit = Exit::no;
  report.findings.push_back({.rule = rule,
                             .message = std::move(message),
                             .document = file.string(),
                             .severity = Severity::error});
}

// Files in public/ are distributed to all participants.
void diagnose_no_key_in_public(const fs::path& keystore, Report& report) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(keystore / "public", error)) {
    const auto octets = read_file(entry.path(), pki::kMaxCertificateOctets);
    if (octets && as_text(*octets).contains("PRIVATE KEY-----"))
      refuse(Rule::DOC004, entry.path(),
             fmt::format("{} holds a private key, and public/ is for all participants",
                         entry.path().string()),
             report);
  }
}

// The folders of the enclaves are checked with the rest of each enclave.
void diagnose_writable_places(const fs::path& keystore, Report& report) {
  struct stat status {};
  if (::stat(keystore.c_str(), &status) != 0) return;
  doctor::WritablePlaces places(status.st_uid);
  places.add_with_way(keystore);
  for (const auto* name : {"private", "public", "enclaves"}) places.add(keystore / name);
  for (const auto& finding : places.findings()) {
    if (finding.severity == Severity::error) report.exit = Exit::no;
    report.findings.push_back(finding);
  }
}

void add_empty(const fs::path& keystore, const Enclaves& enclaves, Report& report) {
  for (const auto& name : enclaves.empty) {
    const auto folder = keystore / enclave_folder(name);
    report.findings.push_back({.rule = Rule::DOC105,
                               .message = fmt::format("{} is empty", folder.string()),
                               .document = folder.string()});
  }
}

// A CA's key in an enclave is an error here: a copy of the enclave for its device would contain the
// key.
void add_findings_of(const doctor::Diagnosis& diagnosis, Report& report) {
  for (const auto& check : diagnosis.checks())
    for (auto finding : check.findings) {
      // A folder above several enclaves is reported once.
      if (finding.rule == Rule::DOC104 &&
          std::ranges::find(report.findings, finding.message, &Finding::message) !=
              report.findings.end())
        continue;
      if (finding.rule == Rule::DOC004) {
        finding.severity = Severity::error;
        report.exit = Exit::no;
      }
      report.findings.push_back(std::move(finding));
    }
}

}  // namespace

Result<Answer<VerifiedKeystore>> keystore_verify(const Arguments& arguments,
                                                 const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  const auto now = context.clock.calendar_seconds();
  Answer<VerifiedKeystore> out;
  auto& [result, report, has_result] = out;
  const auto enclaves = enclaves_of(keystore);
  for (const auto& key : private_keys(keystore, enclaves)) {
    if (!is_for_others(key)) continue;
    result.keys_for_others.push_back(key.string());
    if (key.parent_path() == keystore / "private")  // DOC003 reports an enclave's own key
      report.errors.emplace_back(Code::key_readable_by_others, ErrorDetails{.document = key});
  }
  diagnose_no_key_in_public(keystore, report);
  diagnose_writable_places(keystore, report);
  add_empty(keystore, enclaves, report);
  Report domains;
  KeyCopies key_copies(keystore);
  const auto lineup = installed_lineup();
  for (const auto& name : enclaves.names) {
    const auto folder =
        pki::participant_folder(keystore / enclave_folder(name), pki::FolderLayout::sros2);
    const auto loaded = doctor::load_folder(folder, now);
    DDSSEC_ASSIGN_OR_RETURN(const auto domain, domain_for(arguments, {&loaded}, now, domains));
    const doctor::Settings settings{.now = now, .domain = domain, .lineup = lineup};
    auto diagnosis = doctor::diagnose(loaded, settings);
    doctor::diagnose_ros_rights(loaded, settings, diagnosis);
    doctor::diagnose_lint(loaded, settings, diagnosis);
    diagnose_renewal_list(loaded, settings, diagnosis);
    VerifiedEnclave enclave{name, domain};
    for (const auto product : doctor::kProducts) {
      const auto outcome = diagnosis.outcomes().of(product);
      if (outcome != doctor::Outcome::ok) report.exit = Exit::no;
      enclave.verdicts[doctor::id(product, lineup)] = to_string(outcome);
      enclave.words += fmt::format("  {}: {}", doctor::id(product, lineup), to_string(outcome));
    }
    add_findings_of(diagnosis, report);
    diagnose_belongs(keystore, loaded, name, report);
    key_copies.add(loaded, name, report);
    result.enclaves.push_back(std::move(enclave));
  }
  add_once(domains.findings, report);
  if (!result.keys_for_others.empty()) report.exit = Exit::no;
  add_unseen(enclaves, report);
  return out;
}

namespace {

void add_error(Error error, Report& report) {
  report.exit = std::max(report.exit, exit_of(error.code()));
  report.errors.push_back(std::move(error));
}

// Adds the certificates of enclaves to the CA's log.
struct Import {
  const CaPaths& paths;
  const pki::Certificate& ca;
  const pki::IssueLog& log;
  std::map<std::string, fs::path> seen = {};
  std::string lines = {};

  Status add(const fs::path& folder, const std::string& name, WallTime now,
             ImportedKeystore& done) {
    DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(folder / "cert.pem"));
    if (!certificate.is_issued_by(ca))
      return fail(Code::issuer_unknown, {.document = folder / "cert.pem",
                                         .expected = "one that " + ca.subject() + " issued",
                                         .found = "one of " + certificate.issuer()});
    DDSSEC_RETURN_IF_ERROR(check_alone(certificate, folder, paths, log, seen));
    std::error_code ignored;
    if (log.find(certificate.serial()) != nullptr) return {};
    lines += pki::IssueLog::issued_line(
        certificate, fs::absolute(folder, ignored).lexically_normal().string(), now);
    done.logged.push_back(name);
    done.subjects.push_back(certificate.subject());
    return {};
  }
};

// A keystore may come from another user, who can replace its folders by links to any folder of this
// user.
Status check_own_folders(const fs::path& keystore) {
  for (const auto* name : {"private", "enclaves"}) {
    std::error_code ignored;
    if (!fs::is_symlink(keystore / name, ignored)) continue;
    return fail(Code::file_unwritable,
                {.document = keystore / name,
                 .note = "it is a symbolic link: what it leads to may not belong to the keystore",
                 .hint = "move the folder itself to that place"});
  }
  return {};
}

// Changes exactly the folder that was checked, even if its name leads elsewhere meanwhile.
void restrict_folder_mode(const fs::path& folder, Answer<ImportedKeystore>& out) {
  const int open = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (open < 0) return;  // there is no such folder in a keystore without keys
  struct stat status {};
  const bool is_open = ::fstat(open, &status) == 0 && (status.st_mode & 077) != 0;
  const int error = is_open && !writes_nothing() && ::fchmod(open, 0700) != 0 ? errno : 0;
  ::close(open);
  if (error != 0) return add_error(Error(Code::file_unwritable, {.document = folder}), out.report);
  if (!is_open) return;
  out.result.folders_closed.push_back(folder.string());
  out.result.closed_mode = fmt::format("{:03o}", status.st_mode & 0777U);
}

// A key that cannot be restricted does not prevent restricting the others.
void restrict_key_modes(const fs::path& keystore, const Enclaves& enclaves,
                        Answer<ImportedKeystore>& out) {
  for (const auto& key : private_keys(keystore, enclaves)) {
    if (!is_for_others(key)) continue;
    const auto is_closed = restrict_key_mode(key);
    if (!is_closed) add_error(is_closed.error(), out.report);
    if (!is_closed || !*is_closed) continue;
    out.result.keys_closed.push_back(key.string());
  }
}

}  // namespace

Result<Answer<ImportedKeystore>> keystore_import(const Arguments& arguments,
                                                 const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  DDSSEC_RETURN_IF_ERROR(check_own_folders(keystore));
  const auto paths = ca_paths(keystore, "identity");
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, read_certificate(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(paths));
  Answer<ImportedKeystore> out;
  const auto enclaves = enclaves_of(keystore);
  Import import{.paths = paths, .ca = ca, .log = log};
  for (const auto& name : enclaves.names) {
    auto added = import.add(keystore / enclave_folder(name), name, context.clock.calendar_seconds(),
                            out.result);
    // The user must decide which of two enclaves has the other's certificate; nothing is logged.
    if (!added && added.error().code() == Code::certificate_of_another_folder) {
      auto details = added.error().details();
      details.hint = fmt::format("ddssec keystore verify {} names the enclave that is the copy",
                                 shell_word(keystore.string()));
      return fail(Code::certificate_of_another_folder, std::move(details));
    }
    if (!added) add_error(std::move(added).error(), out.report);
  }
  restrict_key_modes(keystore, enclaves, out);
  restrict_folder_mode(keystore / "private", out);
  if (!import.lines.empty()) DDSSEC_RETURN_IF_ERROR(log_issued(paths, import.lines));
  out.result.is_complete = out.report.errors.empty();
  add_unseen(enclaves, out.report);
  return out;
}

}  // namespace ddssec::cli
