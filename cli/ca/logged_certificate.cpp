#include "cli/ca/logged_certificate.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/participant_places.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using pki::IssuedCertificate;

fs::path normal_folder(const fs::path& folder) {
  std::error_code ignored;
  auto out = fs::absolute(folder, ignored).lexically_normal();
  return out.has_filename() ? out : out.parent_path();
}

// Compares with the folder that is held for `given`, if there is one, because the path may lead
// elsewhere by now.
bool is_same_folder(const fs::path& a, const fs::path& b, const fs::path& given) {
  std::error_code ignored;
  return a == b || fs::equivalent(a, path_in_held_folder(given), ignored);
}

// The serial number alone is not enough, because a stolen key can sign any certificate.
const IssuedCertificate* entry_of(const pki::Certificate& certificate, const pki::IssueLog& log) {
  const auto* entry = log.find(certificate.serial());
  if (entry == nullptr || entry->subject != certificate.subject()) return nullptr;
  const bool is_same = entry->sha256.empty() || entry->sha256 == to_hex(certificate.fingerprint());
  return is_same ? entry : nullptr;
}

bool has_enclaves_name(const pki::Certificate& certificate, const fs::path& folder,
                       const LoggedFolders& places) {
  if (!places.keystore()) return false;
  std::error_code ignored;
  const auto root = fs::weakly_canonical(*places.keystore() / "enclaves", ignored);
  const auto name = fs::weakly_canonical(folder, ignored).lexically_relative(root);
  return !name.empty() && *name.begin() != ".." &&
         certificate.subject() == "CN=/" + name.generic_string();
}

std::string to_text(const IssuedCertificate& issued) {
  return fmt::format("{}, serial {}", issued.subject, issued.serial);
}

// The newest entry whose folder has this path, or nullptr. Only paths are compared, because a
// look-up in the file system for each entry of a long log is slow.
const IssuedCertificate* issued_for(const fs::path& folder, const pki::IssueLog& log) {
  std::error_code ignored;
  const auto real = fs::weakly_canonical(folder, ignored).string();
  const auto& all = log.issued();
  const auto found = std::find_if(all.rbegin(), all.rend(), [&](const auto& issued) {
    return !issued.folder.empty() && issued.file.empty() &&
           (issued.folder == folder || issued.folder == real);
  });
  return found == all.rend() ? nullptr : &*found;
}

bool lies_in(const fs::path& folder, const pki::Certificate& certificate) {
  const auto found = certificate_of_others(folder);
  return found && *found == certificate;
}

// Looks for revocations of this key in the log, then in the CA's list.
std::string revoked_serial_of_key(const pki::Certificate& certificate,
                                  const std::vector<pki::Revocation>& listed,
                                  const pki::IssueLog& log) {
  const pki::KeyDigests key(certificate);
  if (auto serial = log.revoked_serial(key); !serial.empty()) return serial;
  for (const auto& issued : log.issued())
    if (key.contains(issued.key) &&
        std::ranges::find(listed, issued.serial, &pki::Revocation::serial) != listed.end())
      return issued.serial;
  return {};
}

std::unexpected<Error> other_issuer_error(const pki::Certificate& certificate,
                                          const pki::Certificate& ca, const fs::path& path,
                                          std::string hint) {
  return fail(Code::issuer_unknown, {.document = path,
                                     .expected = "a certificate that " + ca.subject() + " issued",
                                     .found = "one of " + certificate.issuer(),
                                     .hint = std::move(hint)});
}

}  // namespace

Status check_issuer(const pki::Certificate& certificate, const OpenCa& ca, const fs::path& path) {
  if (certificate.is_issued_by(ca.certificate())) return {};
  if (certificate.issuer() != ca.certificate().subject())
    return other_issuer_error(certificate, ca.certificate(), path,
                              "name the folder of the CA that issued it: --ca DIR");
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(ca.paths));
  const auto is_issuer = [&](const auto& one) { return certificate.is_issued_by(one); };
  if (overlap && std::ranges::any_of(overlap->former, is_issuer))
    return fail(tool_code::not_moved_yet, {.document = path});
  auto error =
      other_issuer_error(certificate, ca.certificate(), path,
                         "issue the participant again: ddssec identity issue --replace; or name "
                         "the folder of the CA that issued it: --ca DIR");
  auto details = error.error().details();
  details.note =
      "the CA of that name has another key now: it was rotated while this folder was away, or "
      "there "
      "are two";
  return fail(Code::issuer_unknown, std::move(details));
}

bool is_logged(const pki::Certificate& certificate, const pki::IssueLog& log) {
  const auto* entry = entry_of(certificate, log);
  return entry != nullptr && !entry->sha256.empty();
}

LogStatus log_status_of(const pki::Certificate& certificate, const fs::path& given,
                        const CaPaths& ca, const pki::IssueLog& log) {
  const auto folder = normal_folder(given);
  const LoggedFolders places(ca, log);
  const auto* entry = entry_of(certificate, log);
  if (entry == nullptr) {
    const bool is_logged = log.find(certificate.serial()) != nullptr;
    return !is_logged && has_enclaves_name(certificate, folder, places) ? LogStatus::own
                                                                        : LogStatus::unlogged;
  }
  const auto home = entry->folder.empty() ? fs::path() : places.today(entry->folder);
  if (!home.empty() && is_same_folder(home, folder, given)) return LogStatus::own;
  const bool is_copy = !home.empty() && lies_in(home, certificate);
  return is_copy || issued_for(folder, log) != nullptr ? LogStatus::foreign : LogStatus::moved;
}

fs::path recorded_folder(const pki::Certificate& certificate, const fs::path& folder,
                         const CaPaths& ca, const pki::IssueLog& log) {
  const auto* entry = entry_of(certificate, log);
  const bool is_own = entry != nullptr && !entry->folder.empty() &&
                      log_status_of(certificate, folder, ca, log) == LogStatus::own;
  return is_own ? LoggedFolders(ca, log).today(entry->folder) : normal_folder(folder);
}

Status check_own(const pki::Certificate& certificate, const fs::path& folder, const CaPaths& ca,
                 const pki::IssueLog& log, const std::string& subject) {
  const auto log_status = log_status_of(certificate, folder, ca, log);
  const bool is_another = log_status == LogStatus::unlogged && log.find(certificate.serial());
  if (log_status == LogStatus::own && subject.empty()) return {};
  const auto* wanted = issued_for(normal_folder(folder), log);
  ErrorDetails details{
      .document = folder / "cert.pem",
      .expected = !subject.empty()    ? subject
                  : wanted == nullptr ? "one that " + ca.log.string() + " has for this folder"
                                      : to_text(*wanted) + ", issued for this folder",
      .found = fmt::format("{}, serial {}", certificate.subject(), certificate.serial())};
  if (!subject.empty() && !is_another) {
    DDSSEC_ASSIGN_OR_RETURN(const auto named, pki::SubjectName::parse(subject));
    if (pki::SubjectName::of(certificate).key() == named.key()) return {};
    return fail(Code::certificate_of_another_folder, std::move(details));
  }
  if (log_status == LogStatus::unlogged)
    return fail(Code::certificate_unlogged, std::move(details));
  const auto logged = log.find(certificate.serial())->place();
  details.found += logged.empty() ? ", issued for no folder" : ", issued for " + logged;
  return fail(Code::certificate_of_another_folder, std::move(details));
}

Status check_alone(const pki::Certificate& certificate, const fs::path& folder, const CaPaths& ca,
                   const pki::IssueLog& log, std::map<std::string, fs::path>& seen) {
  const auto [first, is_new] = seen.try_emplace(certificate.serial(), folder);
  if (!is_new)
    return fail(Code::certificate_of_another_folder,
                {.document = folder / "cert.pem",
                 .found = certificate.subject() + ", which is also in " + first->second.string()});
  if (log_status_of(certificate, folder, ca, log) != LogStatus::foreign) return {};
  return check_own(certificate, folder, ca, log, {});
}

Result<std::string> revoked_serial(const pki::Certificate& certificate, const CaPaths& ca,
                                   const pki::IssueLog& log, NextKey next) {
  const auto serial = certificate.serial();
  if (log.is_revoked(serial)) return serial;
  DDSSEC_ASSIGN_OR_RETURN(const auto listed, listed_revocations(ca));
  if (std::ranges::find(listed, serial, &pki::Revocation::serial) != listed.end()) return serial;
  const auto* entry = entry_of(certificate, log);
  for (const auto& other : log.issued()) {
    if (!other.revoked) continue;
    const bool is_of_it = other.subject == certificate.subject() ||
                          (entry != nullptr && entry->shares_place_with(other));
    const bool is_later = entry == nullptr || &other > entry;
    const bool had_ended = certificate.not_after() <= other.revoked->time;
    if (is_of_it && (is_later || had_ended)) return other.serial;
  }
  return next == NextKey::same ? revoked_serial_of_key(certificate, listed, log) : std::string();
}

Status check_key_not_revoked(const pki::Certificate& certificate, const fs::path& file,
                             const CaPaths& ca, const pki::IssueLog& log) {
  DDSSEC_ASSIGN_OR_RETURN(const auto listed, listed_revocations(ca));
  const auto serial = revoked_serial_of_key(certificate, listed, log);
  if (serial.empty()) return {};
  return fail(Code::certificate_revoked,
              {.document = file,
               .found = certificate.subject(),
               .note = fmt::format("serial {}, which is revoked, has the same key", serial),
               .hint = "make a new key and a new request for it: ddssec identity csr"});
}

Status check_not_revoked(const pki::Certificate& certificate, const fs::path& file,
                         const CaPaths& ca, const pki::IssueLog& log, NextKey next) {
  DDSSEC_ASSIGN_OR_RETURN(const auto serial, revoked_serial(certificate, ca, log, next));
  if (serial.empty()) return {};
  ErrorDetails details{.document = file, .found = certificate.subject()};
  if (serial != certificate.serial())
    details.note = fmt::format("serial {}, which the participant had, is revoked", serial);
  return fail(Code::certificate_revoked, std::move(details));
}

std::string former_certificate_text(const fs::path& file, const fs::path& given, WallTime now) {
  const auto former = read_certificate(file);
  if (!former || former->not_after() < now) return {};
  const auto log = read_issue_log(ca_paths(given, "identity"));
  if (log && log->is_revoked(former->serial())) return {};
  return fmt::format(
      "the certificate before it is valid until {}; if its key may be in other hands: ddssec "
      "identity revoke {} --ca {}\n",
      date(former->not_after()), former->serial(), given.string());
}

Status check_issued_for(const pki::Certificate& certificate, const fs::path& folder,
                        const CaPaths& ca) {
  const auto file = folder / "cert.pem";
  DDSSEC_ASSIGN_OR_RETURN(const auto issuer, read_certificate(ca.certificate));
  if (!certificate.is_issued_by(issuer))
    return other_issuer_error(certificate, issuer, file, "put the folder's own certificate back");
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca));
  DDSSEC_RETURN_IF_ERROR(check_own(certificate, folder, ca, log, {}));
  return check_not_revoked(certificate, file, ca, log, NextKey::same);
}

}  // namespace ddssec::cli
