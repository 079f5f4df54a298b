#include "cli/ca/participant_places.hpp"

#include <algorithm>
#include <fcntl.h>
#include <set>
#include <sys/stat.h>

#include <fmt/format.h>

#include "base/guarded_path.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

fs::path full_path(const fs::path& path) {
  std::error_code ignored;
  return fs::absolute(path, ignored).lexically_normal();
}

bool is_below(const fs::path& path, const fs::path& root) {
  return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

// The folder that usually contains the CA's participants: the keystore, or the folder that contains
// the CA's folder (as `init` makes it, or `ca create ca` with `identity issue -o talker`).
fs::path root_of(const CaPaths& ca, bool is_keystore) {
  const auto folder = full_path(ca.log).parent_path();
  const auto role = folder.filename();
  const bool has_two_roles = role == "identity" || role == "permissions";
  return is_keystore || !has_two_roles ? folder.parent_path() : folder.parent_path().parent_path();
}

bool is_same_certificate(const fs::path& path, const pki::Certificate& certificate) {
  if (!path_exists(path)) return false;
  const auto found = read_certificate(path);
  return found && std::ranges::equal(found->fingerprint(), certificate.fingerprint());
}

// The kind of CA that issued the certificate in a folder of this machine.
enum class Issuer : std::uint8_t { present, before_rotation, other };

// An unreadable certificate counts as issued by the CA: the command that works on the folder
// reports it.
Issuer issuer_in(const fs::path& folder, const std::vector<pki::Certificate>& cas,
                 const pki::IssueLog& log) {
  const auto certificate = read_certificate(folder / "cert.pem");
  const auto is_issuer = [&](const auto& ca) { return certificate->is_issued_by(ca); };
  if (!certificate || std::ranges::any_of(cas, is_issuer)) return Issuer::present;
  return is_logged(*certificate, log) ? Issuer::before_rotation : Issuer::other;
}

void add_unlogged(const fs::path& keystore, const pki::Certificate& ca, const pki::IssueLog& log,
                  std::set<fs::path>& seen, ParticipantPlaces& out) {
  auto enclaves = enclaves_of(keystore);
  out.unseen = std::move(enclaves.unseen);
  for (const auto& name : enclaves.names) {
    const auto folder = keystore / enclave_folder(name);
    if (seen.contains(folder)) continue;
    const auto certificate = read_certificate(folder / "cert.pem");
    if (!certificate || !certificate->is_issued_by(ca) || log.is_revoked(certificate->serial()))
      continue;
    if (log.find(certificate->serial()) == nullptr) out.unlogged.push_back(name);
    seen.insert(folder);
    out.here.push_back(folder);
  }
}

void add_here(const fs::path& folder, Issuer issuer, ParticipantPlaces& out) {
  if (issuer == Issuer::present)
    out.here.push_back(folder);
  else
    (issuer == Issuer::other ? out.of_other_cas : out.left_behind).push_back(folder);
}

std::string lines(std::string_view title, const std::vector<std::string>& folders) {
  constexpr std::size_t kMax = 10;
  if (folders.empty()) return "";
  auto out = fmt::format("  {}:\n", title);
  for (std::size_t i = 0; i < std::min(kMax, folders.size()); ++i)
    out += fmt::format("    {}\n", folders[i]);
  if (folders.size() > kMax) out += fmt::format("    and {} more\n", folders.size() - kMax);
  return out;
}

}  // namespace

LoggedFolders::LoggedFolders(const CaPaths& ca, const pki::IssueLog& log) : ca_(ca), log_(log) {
  const bool is_keystore = ca.log.filename() == "identity_ca.issued.jsonl";
  root_ = root_of(ca, is_keystore);
  if (is_keystore) keystore_ = root_;
}

bool LoggedFolders::is_inside(const fs::path& folder) const { return is_below(folder, root_); }

std::optional<pki::Certificate> certificate_of_others(const fs::path& folder) {
  const auto opened = open_guarded(folder, O_PATH);
  if (!opened || !*opened) return std::nullopt;
  const FileDescriptor file(
      ::openat(opened->number(), "cert.pem", O_PATH | O_NOFOLLOW | O_CLOEXEC));
  struct stat status {};
  if (!file || ::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode))
    return std::nullopt;
  auto out = read_certificate(fmt::format("/proc/self/fd/{}", file.number()));
  return out ? std::optional(*std::move(out)) : std::nullopt;
}

bool LoggedFolders::holds_logged(const fs::path& folder, const std::string& logged) const {
  const auto certificate = certificate_of_others(folder);
  if (!certificate) return false;
  const auto* issued = log_.find(certificate->serial());
  return issued != nullptr && issued->folder == logged;
}

fs::path LoggedFolders::today(const std::string& logged) const {
  const fs::path as_logged = logged;
  std::error_code error;
  if (is_inside(as_logged) && (fs::exists(as_logged / "cert.pem", error) || error))
    return as_logged;
  auto rest = as_logged.relative_path();
  while (!rest.empty()) {
    if (holds_logged(root_ / rest, logged)) return root_ / rest;
    fs::path shorter;
    for (auto part = std::next(rest.begin()); part != rest.end(); ++part) shorter /= *part;
    rest = shorter;
  }
  return as_logged;
}

bool LoggedFolders::is_of_another_copy(const fs::path& folder) const {
  if (is_inside(folder)) return false;
  const auto ca = read_certificate(ca_.certificate);
  if (!ca) return false;
  for (auto at = folder; at.has_relative_path(); at = at.parent_path())
    for (const auto* place : {"public/identity_ca.cert.pem", "ca/identity/ca.pem", "ca/ca.pem"})
      if (is_same_certificate(at / place, *ca)) return true;
  return false;
}

Result<ParticipantPlaces> participant_places(const CaPaths& ca, const pki::IssueLog& log) {
  ParticipantPlaces out;
  if (log.issued().empty() && ca.log.filename() != "identity_ca.issued.jsonl") return out;
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(ca.certificate));
  std::vector<pki::Certificate> cas{certificate};
  // During an overlap, a participant that has not moved accepts those that have, and needs their
  // list. If the record of the overlap cannot be read, participants of all former CAs are included:
  // one list too many does no harm.
  const auto overlap = read_overlap(ca);
  const auto of_former = overlap ? Issuer::before_rotation : Issuer::present;
  if (overlap && *overlap)
    cas.insert(cas.end(), (*overlap)->former.begin(), (*overlap)->former.end());
  const LoggedFolders folders(ca, log);
  const auto present = log.present_places();
  std::set<fs::path> seen;
  for (const auto& logged : log.places()) {
    const auto folder = folders.today(logged);
    std::error_code error;  // a folder that cannot be entered counts as here
    const bool is_here = fs::exists(folder / "cert.pem", error) || error;
    if (folders.is_of_another_copy(folder)) {
      out.other_copies.push_back(logged);
    } else if (!is_here) {
      if (present.contains(logged)) out.elsewhere.push_back(logged);
    } else if (seen.insert(folder).second) {
      const auto issuer = issuer_in(folder, cas, log);
      add_here(folder, issuer == Issuer::before_rotation ? of_former : issuer, out);
      const bool is_outside = folders.keystore() && !folders.is_inside(folder);
      if (is_outside && !out.here.empty() && out.here.back() == folder)
        out.outside.push_back(folder);
    }
  }
  if (folders.keystore()) add_unlogged(*folders.keystore(), certificate, log, seen, out);
  return out;
}

bool are_all_revoked(const pki::IssueLog& log) {
  const auto has_folder = [](const auto& issued) { return !issued.folder.empty(); };
  return log.places().empty() && std::ranges::any_of(log.issued(), has_folder);
}

std::vector<std::string> revoked_folders(const CaPaths& ca, const pki::IssueLog& log) {
  const LoggedFolders logged(ca, log);
  std::vector<std::string> out;
  std::set<fs::path> seen;
  const auto look = [&](const fs::path& folder) {
    const auto certificate = certificate_of_others(folder);
    if (certificate && log.is_revoked(certificate->serial()) &&
        !logged.is_of_another_copy(folder) && seen.insert(folder).second)
      out.push_back(folder.string());
  };
  for (const auto& place : log.revoked_places()) look(logged.today(place));
  if (const auto& keystore = logged.keystore())
    for (const auto& name : enclaves_of(*keystore).names) look(*keystore / enclave_folder(name));
  return out;
}

std::string revoked_folders_text(const std::vector<std::string>& folders) {
  return lines(
      "left out: the certificate is revoked, so that other participants refuse this one when they "
      "have the list; to put the list here too, name the folder",
      folders);
}

std::string places_text(const ParticipantPlaces& places, const CaPaths& ca) {
  const auto crl = ca.crl.string();
  auto out =
      lines("outside of the keystore", places.outside) +
      lines(fmt::format("not on this machine, copy {} there as crl.pem", crl), places.elsewhere) +
      lines(
          "left out: the certificate is of the CA as it was before a rotation, which this list "
          "says nothing of; make the folder writable and rotate the CA once more",
          places.left_behind) +
      lines("left out: the certificate in the folder is of another CA", places.of_other_cas) +
      lines(
          "left out, since another copy of this CA lies beside it; name the folder to put this "
          "list into it",
          places.other_copies);
  if (!places.here.empty())
    out += fmt::format(
        "  copies of these folders on other machines are not reached: copy {} there "
        "as crl.pem\n",
        crl);
  if (!places.unlogged.empty())
    out += lines(
        "not in the CA's log, which renewals and rotations go by; ddssec keystore import adds them",
        places.unlogged);
  return out;
}

}  // namespace ddssec::cli
