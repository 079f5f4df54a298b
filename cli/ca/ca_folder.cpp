#include "cli/ca/ca_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/guarded_path.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/passphrase.hpp"
#include "pki/certificate_source.hpp"
#include "pki/participant_folder.hpp"

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

// True for the form of sros2: one key for both roles, with a link to it in the same folder.
bool links_to_neighbour(const fs::path& key) {
  std::error_code error;
  const auto target = fs::read_symlink(key, error);
  return !error && !target.has_parent_path() &&
         fs::symlink_status(key.parent_path() / target, error).type() == fs::file_type::regular;
}

// Another user's link in the path could lead to another CA, whose key would sign what that user
// asks for, or be replaced. A name after the key's own makes open_guarded() judge the key, too.
Status check_links_to(const fs::path& key) {
  const auto way = open_guarded(links_to_neighbour(key) ? key : key / "end", O_PATH);
  if (way) return {};
  auto details = way.error().details();
  details.document = key;
  return fail(way.error().code(), std::move(details));
}

// The files of the key are read and replaced in this folder, wherever its path leads later.
Status hold_folder_of(const fs::path& key) {
  std::error_code error;
  const auto folder = key.parent_path();
  const bool is_folder = fs::symlink_status(folder, error).type() == fs::file_type::directory;
  return is_folder ? hold_folder(folder) : Status();
}

}  // namespace

Result<std::string> role_option(const Arguments& arguments) {
  auto role = arguments.text("--role");
  if (role == "identity" || role == "permissions") return role;
  return fail(Code::usage,
              {.field = "--role", .expected = "identity or permissions", .found = role});
}

// Does the part that may have to wait for user input.
Status CaOpener::prepare(const fs::path& path) {
  DDSSEC_RETURN_IF_ERROR(check_key_mode(path, arguments_));
  if (path.extension() != ".p11" && !passphrase_) {
    DDSSEC_ASSIGN_OR_RETURN(const auto encrypted, is_encrypted(path));
    if (encrypted) {
      DDSSEC_ASSIGN_OR_RETURN(passphrase_, passphrase(arguments_));
    }
  }
  return {};
}

Result<pki::PrivateKey> CaOpener::key(const fs::path& path) {
  DDSSEC_RETURN_IF_ERROR(prepare(path));
  if (path.extension() == ".p11") {
    DDSSEC_ASSIGN_OR_RETURN(const auto uri, pki::uri_of(path));
    return with_default_document(token_key(uri, arguments_), path);
  }
  return read_key(path, passphrase_ ? &*passphrase_ : nullptr);
}

Result<OpenCa> CaOpener::open(const CaPaths& paths) {
  DDSSEC_RETURN_IF_ERROR(finish_interrupted(paths.key.parent_path(), Reach::anywhere));
  DDSSEC_RETURN_IF_ERROR(
      // Checked first, so that the user types no passphrase for a folder without a CA.
      read_certificates(paths.certificate));
  DDSSEC_RETURN_IF_ERROR(check_links_to(paths.key));
  DDSSEC_RETURN_IF_ERROR(hold_folder_of(paths.key));
  DDSSEC_RETURN_IF_ERROR(prepare(paths.key));
  DDSSEC_ASSIGN_OR_RETURN(auto&& lock, lock_records(paths));
  DDSSEC_ASSIGN_OR_RETURN(const auto trust, read_certificates(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(auto own_key, key(paths.key));
  // The owner of the folder can put a link there while this command waits for the lock.
  DDSSEC_RETURN_IF_ERROR(check_links_to(paths.key));
  DDSSEC_ASSIGN_OR_RETURN(
      auto authority, with_default_document(pki::Authority::load(trust.front(), std::move(own_key)),
                                            paths.certificate));
  return OpenCa{paths, std::move(authority), to_pem(trust), std::move(lock)};
}

Result<OpenCa> CaOpener::open(std::string_view role) {
  const fs::path given = arguments_.text("--ca");
  DDSSEC_RETURN_IF_ERROR(check_signing_ca(given, role));
  return open(ca_paths(given, role));
}

Result<std::vector<pki::Certificate>> read_certificates(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(path, pki::kMaxBundleOctets));
  return with_default_document(pki::Certificate::bundle_from_pem(octets), path);
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
  DDSSEC_ASSIGN_OR_RETURN(const auto text, read_file(paths.log, pki::kMaxIssueLogOctets));
  auto log = pki::IssueLog::parse(text);
  std::vector<int> lines;
  for (const auto& line : log.unreadable()) lines.push_back(line.details().line);
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
  DDSSEC_RETURN_IF_ERROR(check_log_lines(paths.log, lines));
  return append_lines(paths.log, lines, paths.key);
}

Result<std::optional<FileLock>> lock_records(const CaPaths& paths) {
  const bool can_open = ::faccessat(AT_FDCWD, paths.key.c_str(), R_OK, AT_EACCESS) == 0;
  if (!can_open && (errno == ENOENT || errno == EACCES)) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(auto file_lock, FileLock::of(paths.key));
  return file_lock;
}

Status add_key(NewFolder& folder, const fs::path& name, const NewKey& key,
               const pki::Passphrase* passphrase) {
  if (!key.token_uri.empty())
    return folder.add(fs::path(name).replace_extension(".p11"), as_bytes(key.token_uri + '\n'),
                      0600);
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, key.key.to_pem(passphrase));
  return pem.expose([&](BytesView octets) { return folder.add(name, octets, 0600); });
}

// Escapes special characters (RFC 4514, 2.4). A blank at the end of the title is not escaped,
// because the role or "CA" follows it.
std::string ca_subject(std::string_view title, std::string_view role) {
  constexpr std::string_view kSpecial = ",+\"\\<>;=";
  std::string escaped;
  for (const char c : title) {
    const bool begins = escaped.empty() && (c == '#' || c == ' ');
    if (begins || kSpecial.contains(c)) escaped += '\\';
    escaped += c;
  }
  return fmt::format("CN={}{}{} CA", escaped, role.empty() ? "" : " ", role);
}

Status add_ca(NewFolder& folder, const CaPaths& names, std::string_view trust_pem,
              const NewKey& key, const pki::Passphrase* passphrase) {
  DDSSEC_RETURN_IF_ERROR(folder.add_public(names.certificate, trust_pem));
  return add_key(folder, names.key, key, passphrase);
}

}  // namespace ddssec::cli
