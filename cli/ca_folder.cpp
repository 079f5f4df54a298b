#include "cli/ca_folder.hpp"

#include <algorithm>
#include <sys/stat.h>

#include <fmt/format.h>

#include "cli/documents.hpp"
#include "cli/near.hpp"
#include "cli/notices.hpp"
#include "pki/participant_folder.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

Status check_key_mode(const fs::path& key, const Arguments& arguments) {
  struct stat status {};
  if (arguments.has("--insecure-key-mode") || ::stat(key.c_str(), &status) != 0) return {};
  if ((status.st_mode & 077) == 0) return {};
  return fail(Code::key_readable_by_others,
              {.document = key,
               .expected = "mode 0600",
               .found = fmt::format("mode {:04o}", status.st_mode & 07777)});
}

}  // namespace

CaPaths ca_paths_in(const fs::path& folder) {
  return {folder / "ca.pem", pki::or_in_token(folder / "ca.key.pem"), folder / "issued.jsonl",
          folder / "crl.pem", folder / "signed.jsonl"};
}

CaPaths ca_paths(const fs::path& given, std::string_view role) {
  const std::string name = std::string(role) + "_ca";
  if (is_there(given / "public" / (name + ".cert.pem")))  // a keystore of ROS 2
    return {given / "public" / (name + ".cert.pem"), given / "private" / (name + ".key.pem"),
            given / "private" / (name + ".issued.jsonl"), given / "public" / (name + ".crl.pem"),
            given / "private" / (name + ".signed.jsonl")};
  // What `init` made has the CAs one folder below.
  const auto inner = given / "ca";
  const bool from_init = !is_there(given / role / "ca.pem") && is_there(inner / role / "ca.pem");
  return ca_paths_in(ca_folder(from_init ? inner : given, role));
}

fs::path ca_certificate_path(const fs::path& given, std::string_view role) {
  std::error_code ignored;
  return fs::is_directory(given, ignored) ? ca_paths(given, role).certificate : given;
}

Result<std::string> one_role(const Arguments& arguments) {
  auto role = arguments.text("--role");
  if (role == "identity" || role == "permissions") return role;
  return fail(Code::usage,
              {.field = "--role", .expected = "identity or permissions", .found = role});
}

Result<pki::PrivateKey> CaOpener::key(const fs::path& path) {
  DDSSEC_TRY(check_key_mode(path, arguments_));
  if (path.extension() == ".p11")
    return named(token_key(DDSSEC_TRY(pki::uri_of(path)), arguments_), path);
  if (!passphrase_ && DDSSEC_TRY(is_encrypted(path)))
    passphrase_ = DDSSEC_TRY(passphrase(arguments_, Typed::once));
  return read_key(path, passphrase_ ? &*passphrase_ : nullptr);
}

Result<OpenCa> CaOpener::open(const CaPaths& paths) {
  DDSSEC_TRY(finish_interrupted(paths.key.parent_path(), Reach::anywhere));
  const auto trust = DDSSEC_TRY(read_certificates(paths.certificate));
  auto own_key = DDSSEC_TRY(key(paths.key));
  auto authority =
      DDSSEC_TRY(named(pki::Authority::load(trust.front(), std::move(own_key)), paths.certificate));
  return OpenCa{paths, std::move(authority), to_pem(trust)};
}

Result<OpenCa> CaOpener::open(std::string_view role) {
  const fs::path given = arguments_.text("--ca");
  DDSSEC_TRY(check_signing_ca(given, role));
  return open(ca_paths(given, role));
}

Result<std::vector<pki::Certificate>> read_certificates(const fs::path& path) {
  const auto octets = DDSSEC_TRY(read_file(path, pki::kMostBundleOctets));
  return named(pki::Certificate::bundle_from_pem(octets), path);
}

std::string to_pem(const std::vector<pki::Certificate>& certificates) {
  std::string out;
  for (const auto& certificate : certificates) out += certificate.pem();
  return out;
}

Result<pki::IssueLog> read_issue_log(const CaPaths& paths) {
  std::error_code error;
  if (fs::file_size(paths.log, error) == 0 || error == std::errc::no_such_file_or_directory)
    return pki::IssueLog();
  const auto text = DDSSEC_TRY(read_file(paths.log, pki::kMostIssueLogOctets));
  auto log = pki::IssueLog::parse(text);
  std::vector<int> lines;
  for (const auto& error : log.unreadable()) lines.push_back(error.details().line);
  notice_unreadable_lines(paths.log, lines);
  return log;
}

Status check_log_lines(const fs::path& log, std::string_view lines) {
  while (!lines.empty()) {
    const auto end = std::min(lines.find('\n'), lines.size() - 1);
    if (end > pki::kMaxLogLineOctets)
      return fail(Code::length_out_of_range,
                  {.document = log,
                   .expected = fmt::format("at most {} octets", pki::kMaxLogLineOctets),
                   .found = std::to_string(end)});
    lines.remove_prefix(end + 1);
  }
  return {};
}

Status log_issued(const CaPaths& paths, std::string_view lines) {
  DDSSEC_TRY(check_log_lines(paths.log, lines));
  return append_lines(paths.log, lines, paths.key);
}

Result<std::optional<pki::Crl>> read_crl(const fs::path& path) {
  if (!is_there(path)) return std::nullopt;
  const auto octets = DDSSEC_TRY(read_file(path, pki::kMostDocumentOctets));
  const auto lists = DDSSEC_TRY(named(pki::Crl::all_from(octets), path));
  if (lists.empty())
    return fail(Code::crl_malformed, {.document = path, .note = "there is no list in it"});
  return lists.front();
}

Result<FileLock> lock_records(const CaPaths& paths) { return FileLock::of(paths.key); }

Result<bool> lists_all(const CaPaths& paths, const pki::IssueLog& log) {
  if (log.revocations().empty()) return true;
  const auto crl = DDSSEC_TRY(read_crl(paths.crl));
  if (!crl) return false;
  const auto listed = DDSSEC_TRY(named(crl->revoked(), paths.crl));
  return std::ranges::all_of(log.revocations(), [&](const auto& revocation) {
    return std::ranges::find(listed, revocation.serial, &pki::Revocation::serial) != listed.end();
  });
}

namespace {

/// What the list that follows the CA's present one holds.
struct NextList {
  std::uint64_t number;
  std::vector<pki::Revocation> entries;  ///< of the log and of the present list
};

Result<NextList> next_list(const OpenCa& ca, const pki::IssueLog& log) {
  const auto before = DDSSEC_TRY(read_crl(ca.paths.crl));
  auto entries = log.revocations();
  if (before) {
    const auto listed = DDSSEC_TRY(named(before->revoked(), ca.paths.crl));
    entries.insert(entries.end(), listed.begin(), listed.end());
  }
  return NextList{before ? before->number().value_or(0) + 1 : 1, std::move(entries)};
}

Result<pki::Crl> signed_list(const OpenCa& ca, const NextList& list, WallTime now, WallTime until) {
  return ca.authority.make_crl(
      {.this_update = now, .next_update = until, .number = list.number, .entries = list.entries});
}

}  // namespace

Result<pki::Crl> next_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now, int days) {
  const auto list = DDSSEC_TRY(next_list(ca, log));
  return signed_list(ca, list, now, now + std::chrono::days(days));
}

Result<pki::Crl> routine_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now) {
  const auto list = DDSSEC_TRY(next_list(ca, log));
  return signed_list(
      ca, list, now,
      list.entries.empty() ? ca.certificate().not_after() : now + std::chrono::days(kListDays));
}

Result<pki::Crl> first_crl(const pki::Authority& ca) {
  const auto& certificate = ca.certificate();
  return ca.make_crl({.this_update = certificate.not_before(),
                      .next_update = certificate.not_after(),
                      .number = 1,
                      .entries = {}});
}

Result<std::string> list_for_newcomers(const CaPaths& paths, WallTime now) {
  const auto crl = DDSSEC_TRY(read_crl(paths.crl));
  const bool is_over = crl && crl->next_update() && *crl->next_update() <= now;
  return crl && !is_over ? crl->pem() : std::string();
}

Status add_key(NewFolder& folder, const fs::path& name, const NewKey& key,
               const pki::Passphrase* passphrase) {
  if (!key.token_uri.empty())
    return folder.add(fs::path(name).replace_extension(".p11"), as_bytes(key.token_uri + '\n'),
                      0600);
  const auto pem = DDSSEC_TRY(key.key.to_pem(passphrase));
  return pem.expose([&](BytesView octets) { return folder.add(name, octets, 0600); });
}

Status add_ca(NewFolder& folder, const CaPaths& names, std::string_view trust_pem,
              const NewKey& key, const pki::Passphrase* passphrase) {
  DDSSEC_TRY(folder.add_public(names.certificate, trust_pem));
  return add_key(folder, names.key, key, passphrase);
}

}  // namespace ddssec::cli
