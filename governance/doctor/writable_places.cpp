#include "governance/doctor/writable_places.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/folder_rights.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxLinks = 40;  // the limit of Linux
constexpr std::size_t kMaxEntry = 65'536;

std::string name_of_user(uid_t user) {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, kMaxEntry> buffer;
  if (::getpwuid_r(user, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr)
    return found->pw_name;
  return std::to_string(user);
}

struct Group {
  std::string name;
  bool has_others = true;  // true if /etc/group has members other than `user`
};

Group group_of(gid_t id, std::string_view user) {
  group entry{};
  group* found = nullptr;
  std::array<char, kMaxEntry> buffer;
  if (::getgrgid_r(id, &entry, buffer.data(), buffer.size(), &found) != 0 || found == nullptr)
    return {.name = std::to_string(id)};
  Group out{.name = found->gr_name, .has_others = false};
  for (auto member = found->gr_mem; *member != nullptr; ++member) out.has_others |= *member != user;
  return out;
}

// An entry of a POSIX access control list, as Linux stores it: the list begins with a version of
// four octets, and each entry has a tag, rights and an id (acl(5)).
struct AclEntry {
  std::uint16_t tag;
  std::uint16_t rights;
  std::uint32_t id;
};
constexpr std::uint16_t kAclUser = 0x02, kAclGroup = 0x08, kAclMask = 0x10, kAclWrite = 0x02;

std::vector<AclEntry> acl_of(const fs::path& path) {
  constexpr std::size_t kVersion = 4;
  std::array<char, 4096> octets;
  const auto size =
      ::getxattr(path.c_str(), "system.posix_acl_access", octets.data(), octets.size());
  std::vector<AclEntry> out;
  for (auto at = kVersion; size > 0 && at + sizeof(AclEntry) <= static_cast<std::size_t>(size);
       at += sizeof(AclEntry)) {
    AclEntry entry{};
    std::memcpy(&entry, octets.data() + at, sizeof entry);
    out.push_back(entry);
  }
  return out;
}

}  // namespace

WritablePlaces::WritablePlaces(uid_t owner) : owner_(owner) {}

void WritablePlaces::add(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) diagnose_place(path, status);
}

void WritablePlaces::add_with_way(const fs::path& path) {
  add(path);
  int links_left = kMaxLinks;
  add_way(path, links_left);
}

// All links share one limit. Otherwise a path through many links could take very long, because each
// link leads through all links before it.
void WritablePlaces::add_way(const fs::path& path, int& links_left) {
  std::error_code error;
  const auto absolute = fs::absolute(path, error);
  if (error) return;
  fs::path name;
  for (const auto& part : absolute) {
    name /= part;
    if (links_left == 0 || !fs::is_symlink(fs::symlink_status(name, error))) continue;
    add_folders_above(name);
    const auto target = fs::read_symlink(name, error);
    --links_left;
    if (!error) add_way(name.parent_path() / target, links_left);
  }
  const auto real = fs::canonical(absolute, error);
  if (!error) add_folders_above(real);
}

void WritablePlaces::add_folders_above(const fs::path& name) {
  struct stat below {};
  if (::lstat(name.c_str(), &below) != 0) return;
  std::error_code error;
  for (auto folder = fs::canonical(name.parent_path(), error); !error;
       folder = folder.parent_path()) {
    struct stat status {};
    if (::stat(folder.c_str(), &status) != 0) return;
    const bool is_held = is_sticky(status) && is_trusted(below.st_uid);
    if (!is_held || !is_trusted(status.st_uid)) diagnose_place(folder, status);
    if (!folder.has_relative_path()) return;
    below = status;
  }
}

void WritablePlaces::diagnose_place(const fs::path& path, const struct stat& status) {
  const unsigned mode = status.st_mode & 07777U;
  if (!is_trusted(status.st_uid))
    return found(path,
                 fmt::format("{} belongs to the user {}, and the participant to {}", path.string(),
                             name_of_user(status.st_uid), name_of_user(owner_)),
                 Severity::warning);
  if ((mode & S_IWOTH) != 0)
    return found(path,
                 fmt::format("{} can be written by every user of this machine (mode {:03o})",
                             path.string(), mode),
                 Severity::error);
  if (others_may_write(status)) diagnose_acl(path);
  if (!others_may_write(status) || status.st_gid == 0) return;
  const auto user = name_of_user(status.st_uid);
  const auto group = group_of(status.st_gid, user);
  if (group.name == user && !group.has_others) return;
  found(path,
        fmt::format("{} can be written by the group {} (mode {:03o})", path.string(), group.name,
                    mode),
        Severity::warning);
}

// If the file has an access control list, the group's rights in the mode are the upper limit of all
// its entries.
void WritablePlaces::diagnose_acl(const fs::path& path) {
  const auto entries = acl_of(path);
  const auto mask = std::ranges::find(entries, kAclMask, &AclEntry::tag);
  if (mask == entries.end() || (mask->rights & kAclWrite) == 0) return;
  for (const auto& entry : entries) {
    if ((entry.rights & kAclWrite) == 0) continue;
    if (entry.tag == kAclUser && !is_trusted(entry.id))
      found(path,
            fmt::format("{} can be written by the user {} (access control list)", path.string(),
                        name_of_user(entry.id)),
            Severity::warning);
    if (entry.tag == kAclGroup && entry.id != 0)
      found(path,
            fmt::format("{} can be written by the group {} (access control list)", path.string(),
                        group_of(entry.id, {}).name),
            Severity::warning);
  }
}

bool WritablePlaces::is_trusted(uid_t user) const {
  return user == 0 || user == owner_ || user == ::geteuid();
}

void WritablePlaces::found(const fs::path& path, std::string message, Severity severity) {
  if (std::ranges::find(findings_, message, &Finding::message) != findings_.end()) return;
  findings_.push_back({.rule = Rule::DOC104,
                       .message = std::move(message),
                       .document = path.string(),
                       .severity = severity});
}

void WritablePlaces::report(const Outcomes& if_error, Diagnosis& out) const {
  for (const auto& finding : findings_)
    out.report(finding.severity == Severity::error ? if_error : Outcomes(), finding);
}

uid_t user_of(const pki::ParticipantFolder& paths) {
  struct stat status {};
  if (::stat(paths.key.c_str(), &status) != 0) ::stat(paths.folder.c_str(), &status);
  return status.st_uid;
}

void diagnose_files_of_process(const LoadedFolder& folder, std::span<const fs::path> files,
                               Diagnosis& out) {
  WritablePlaces places(user_of(folder.paths));
  for (const auto& file : files) places.add_with_way(file);
  places.report({.cyclonedds = Outcome::unsafe, .ddssec = Outcome::unsafe}, out);
}

}  // namespace ddssec::governance::doctor
