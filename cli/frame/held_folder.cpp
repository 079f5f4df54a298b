#include "cli/frame/held_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <map>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/guarded_path.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct Folder {
  int descriptor;
  bool is_held;  // by hold_folder(): files are also read through it
};

// The descriptors are closed when the process of the command ends.
std::map<std::string, Folder>& folders() {
  static std::map<std::string, Folder> out;
  return out;
}

std::string name_of(const fs::path& folder) {
  const auto& out = folder.has_filename() ? folder : folder.parent_path();
  return out.empty() ? "." : out.string();
}

// A fleet may have more folders than a process may open by default.
bool raise_limit() { return allow_open_files(RLIM_INFINITY); }

int open_folder(int parent, const std::string& name, int flags) {
  flags |= O_DIRECTORY | O_CLOEXEC;
  const int folder = ::openat(parent, name.c_str(), flags);
  if (folder >= 0 || errno != EMFILE || !raise_limit()) return folder;
  return ::openat(parent, name.c_str(), flags);
}

// Opens with O_PATH, because a user without the right to list a folder may still write into it.

int open_and_keep(const std::string& name) {
  const int folder = open_folder(AT_FDCWD, name, O_PATH);
  if (folder >= 0) folders().insert_or_assign(name, Folder{folder, false});
  return folder;
}

Result<FileDescriptor> open_to_hold(const std::string& name) {
  auto folder = open_guarded(name, O_PATH);
  const bool is_full = folder && !*folder && errno == EMFILE;
  return is_full && raise_limit() ? open_guarded(name, O_PATH) : std::move(folder);
}

const Folder* find_held(const fs::path& path) {
  const auto found = folders().find(name_of(path));
  return found != folders().end() && found->second.is_held ? &found->second : nullptr;
}

bool is_link(const std::string& name) {
  struct stat status {};
  return ::lstat(name.c_str(), &status) == 0 && S_ISLNK(status.st_mode);
}

fs::path path_of(int folder) { return fmt::format("/proc/self/fd/{}", folder); }

// Without /proc the files could be read only by their paths.
Status check_proc(int folder, const std::string& name) {
  struct stat by_path {};
  struct stat by_descriptor {};
  const bool is_same =
      ::stat(path_of(folder).c_str(), &by_path) == 0 && ::fstat(folder, &by_descriptor) == 0 &&
      by_path.st_ino == by_descriptor.st_ino && by_path.st_dev == by_descriptor.st_dev;
  if (is_same) return {};
  return fail(Code::file_unwritable,
              {.document = name,
               .note = "/proc is not mounted",
               .hint = "mount it: without it another user could exchange the folder while the "
                       "command reads it"});
}

}  // namespace

bool allow_open_files(rlim_t files) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return false;
  const auto wanted = std::min(files, limit.rlim_max);
  if (limit.rlim_cur >= wanted) return false;
  limit.rlim_cur = wanted;
  return ::setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

Status hold_folder(const fs::path& folder) {
  const auto name = name_of(folder);
  if (find_held(folder) != nullptr) return {};
  DDSSEC_ASSIGN_OR_RETURN(auto opened, open_to_hold(name));
  const int error = errno;
  if (opened) {
    const int number = opened.release();
    folders().insert_or_assign(name, Folder{number, true});
    return check_proc(number, name);
  }
  if (is_link(name))
    return fail(Code::would_overwrite,
                {.document = name,
                 .note = "it is a link, which may be exchanged while the command runs",
                 .hint = "name the folder that the link leads to"});
  return fail(Code::file_unwritable, {.document = name, .note = errno_text(error)});
}

int folder_descriptor(const fs::path& folder) {
  const auto name = name_of(folder);
  const auto found = folders().find(name);
  return found != folders().end() ? found->second.descriptor : open_and_keep(name);
}

FileDescriptor open_folder_in(int parent, const fs::path& name) {
  return FileDescriptor(open_folder(parent, name, O_RDONLY | O_NOFOLLOW));
}

fs::path path_in_held_folder(const fs::path& path) {
  if (const auto* folder = find_held(path)) return path_of(folder->descriptor);
  const auto* parent = path.has_filename() ? find_held(path.parent_path()) : nullptr;
  return parent != nullptr ? path_of(parent->descriptor) / path.filename() : path;
}

int keep_owner(int file, int folder, const fs::path& target, unsigned mode) {
  struct stat former {};
  struct stat draft {};
  const bool is_file =
      ::fstatat(folder, target.filename().c_str(), &former, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISREG(former.st_mode);
  const bool is_root = ::geteuid() == 0;
  constexpr unsigned kPublic = 0044;
  // A file that root adds to a user's folder belongs to that user too, unless it is secret.
  const bool is_new = !is_file && is_root && (mode & kPublic) == kPublic;
  if (is_new && ::fstatat(folder, "", &former, AT_EMPTY_PATH) != 0) return 0;
  if ((!is_file && !is_new) || ::fstat(file, &draft) != 0) return 0;
  if (draft.st_uid == former.st_uid && draft.st_gid == former.st_gid) return 0;
  if (!is_root && draft.st_uid != former.st_uid) return 0;
  if (::fchown(file, is_root ? former.st_uid : ~uid_t{}, former.st_gid) == 0) return 0;
  // The wrong owner does not matter for a file that everyone can read, nor does the wrong group for
  // a file that the group cannot read.
  const bool matters = is_root ? (mode & 044) == 0 : (mode & 044) == 040;
  return matters ? errno : 0;
}

}  // namespace ddssec::cli
