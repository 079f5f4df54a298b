#include "cli/agent/agent_folder.hpp"

#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/guarded_path.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/file_transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kLockName = ".ddssec-agent";
constexpr gid_t kNoGroup = 65534;

std::unexpected<Error> unreadable_folder_error(const fs::path& path, int error) {
  const auto code = error == ENOENT ? Code::file_not_found : Code::file_unreadable;
  ErrorDetails details{.document = path, .note = errno_text(error)};
  if (error == ELOOP || error == ENOTDIR) {
    details.note = "it is no folder, or a link, which may be exchanged";
    details.hint = "name the folder itself, not a link to it";
  }
  return fail(code, std::move(details));
}

// Removes the slash at the end of the path, because a symbolic link with a slash would be followed.
fs::path name_of(const fs::path& folder) {
  return folder.has_filename() ? folder : folder.parent_path();
}

bool is_at(int folder, int file) {
  struct stat by_name {
  }, open{};
  return ::fstatat(folder, kLockName, &by_name, AT_SYMLINK_NOFOLLOW) == 0 &&
         ::fstat(file, &open) == 0 && open.st_ino == by_name.st_ino &&
         open.st_dev == by_name.st_dev;
}

// The folder's owner can put anything in the place of the lock file. A file of another user is
// neither locked nor removed.
bool is_own_file(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 1 &&
         status.st_uid == ::geteuid() && (status.st_mode & 077) == 0;
}

// A user's own group and all groups.
struct Groups {
  gid_t own;
  std::vector<gid_t> all;
};

// The folder's group is used only for a user without an entry in the user database. It may be
// root's, and is then replaced.
Groups groups_of(const FolderOwner& owner) {
  const passwd* entry = ::getpwuid(owner.user);
  if (entry == nullptr) {
    const gid_t group = owner.group == 0 ? kNoGroup : owner.group;
    return {group, {group}};
  }
  constexpr int kMaxGroups = 4096;
  Groups out{entry->pw_gid, std::vector<gid_t>(kMaxGroups)};
  int count = kMaxGroups;
  const bool are_known = ::getgrouplist(entry->pw_name, entry->pw_gid, out.all.data(), &count) >= 0;
  out.all.resize(are_known ? static_cast<std::size_t>(count) : 1);
  if (!are_known) out.all.front() = out.own;
  return out;
}

}  // namespace

Result<FolderOwner> check_folder(int descriptor, const fs::path& folder) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return unreadable_folder_error(folder, errno);
  const uid_t user = ::geteuid();
  ErrorDetails details{.document = folder};
  if (user != 0 && status.st_uid != user) {
    details.expected = fmt::format("a folder of user {}, who runs the agent", user);
    details.found = fmt::format("one of user {}", status.st_uid);
    return fail(tool_code::folder_untrusted, std::move(details));
  }
  if ((status.st_mode & 022) != 0) {
    details.expected = "a folder in which only its owner may write, such as mode 0755 or 0700";
    details.found = fmt::format("mode {:04o}", status.st_mode & 07777);
    return fail(tool_code::folder_untrusted, std::move(details));
  }
  return FolderOwner{status.st_uid, status.st_gid};
}

Status switch_to_owner(const FolderOwner& owner) {
  if (::geteuid() != 0 || owner.user == 0) return {};
  const auto groups = groups_of(owner);
  const bool is_done = ::setgroups(groups.all.size(), groups.all.data()) == 0 &&
                       ::setresgid(groups.own, groups.own, groups.own) == 0 &&
                       ::setresuid(owner.user, owner.user, owner.user) == 0;
  const int error = errno;
  // A change of the user resets this.
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (is_done && ::setuid(0) != 0 && ::geteuid() == owner.user) return {};
  return fail(Code::internal, {.field = fmt::format("the rights of user {}", owner.user),
                               .note = errno_text(error)});
}

Result<FolderLock> FolderLock::acquire(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(auto opened, open_guarded(name_of(path), O_RDONLY));
  if (!opened) return unreadable_folder_error(path, errno);
  const int folder = opened.release();
  FolderLock out(folder, -1);
  DDSSEC_ASSIGN_OR_RETURN(out.locked_.owner, check_folder(folder, path));
  struct stat status {};
  if (::fstat(folder, &status) != 0) return unreadable_folder_error(path, errno);
  out.locked_.device = status.st_dev;
  out.locked_.inode = status.st_ino;
  constexpr int kFlags = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  const int file = ::openat(folder, kLockName, kFlags, 0600);
  if (file < 0) return unwritable_error(path / kLockName, errno);
  const bool is_own = is_own_file(file);
  const bool is_locked = is_own && ::flock(file, LOCK_EX | LOCK_NB) == 0;
  if (is_locked && is_at(folder, file)) {
    out.file_ = file;
    return out;
  }
  ::close(file);
  if (!is_own)
    return fail(tool_code::folder_untrusted,
                {.document = path / kLockName,
                 .expected = fmt::format("a plain file of user {} that no other may open, or none",
                                         ::geteuid()),
                 .found = "another one",
                 .hint = "remove it"});
  return fail(tool_code::agent_is_running, {.document = path});
}

bool LockedFolder::is_same(const struct stat& other) const {
  return other.st_dev == device && other.st_ino == inode && other.st_uid == owner.user;
}

bool FolderLock::is_in_place(const fs::path& path) const {
  struct stat status {};
  return ::lstat(name_of(path).c_str(), &status) == 0 && locked_.is_same(status) &&
         is_at(folder_, file_);
}

Status LockedFolder::check_same(int descriptor, const fs::path& folder) const {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return unreadable_folder_error(folder, errno);
  if (is_same(status)) return {};
  return fail(tool_code::folder_untrusted,
              {.document = folder,
               .expected = fmt::format("the folder of user {} that the agent locked", owner.user),
               .found = fmt::format("a folder of user {} in its place", status.st_uid),
               .hint = "let no other user write in the folders above it"});
}

FolderLock::~FolderLock() {
  if (file_ >= 0 && is_at(folder_, file_)) ::unlinkat(folder_, kLockName, 0);
  if (file_ >= 0) ::close(file_);
  if (folder_ >= 0) ::close(folder_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : folder_(std::exchange(other.folder_, -1)),
      file_(std::exchange(other.file_, -1)),
      locked_(other.locked_) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(file_, other.file_);
  std::swap(locked_, other.locked_);
  return *this;
}

}  // namespace ddssec::cli
