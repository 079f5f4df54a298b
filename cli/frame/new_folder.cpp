#include "cli/frame/new_folder.hpp"

#include <array>
#include <cerrno>
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/frame/held_folder.hpp"
#include "cli/frame/stale_drafts.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Returns six letters, the form that remove_unfinished_folders() knows. They need not be secret,
// because a name that exists is never used.
std::string random_letters() {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEF";
  std::array<std::uint8_t, 6> octets{};
  if (::getentropy(octets.data(), octets.size()) != 0) octets = {};
  std::string out;
  for (const auto octet : octets) out += kLetters[octet % kLetters.size()];
  return out;
}

std::unexpected<Error> exchanged_folder_error(const fs::path& target) {
  return fail(Code::file_unwritable,
              {.document = target,
               .note = "another user or program exchanged the unfinished folder",
               .hint = "make it where only you can write, and move it afterwards"});
}

// In an open folder, only another process can remove a folder or put a link there.
std::unexpected<Error> unwritable_in_folder_error(const fs::path& target, const fs::path& name,
                                                  int error) {
  if (error == ENOENT || error == ELOOP || error == ENOTDIR) return exchanged_folder_error(target);
  return unwritable_error(target / name, error);
}

bool is_empty(int folder) {
  auto listed = open_folder_in(folder, ".");
  DIR* listing = listed ? ::fdopendir(listed.number()) : nullptr;
  if (listing == nullptr) return false;
  listed.release();  // closedir() closes the descriptor
  int entries = 0;
  while (entries <= 2 && ::readdir(listing) != nullptr) ++entries;
  ::closedir(listing);
  return entries <= 2;  // "." and ".."
}

bool is_same(const struct stat& one, const struct stat& other) {
  return one.st_ino == other.st_ino && one.st_dev == other.st_dev;
}

// True if the name leads to the open folder itself.
bool is_at(int parent, const std::string& name, int folder) {
  struct stat by_name {};
  struct stat open {};
  return ::fstatat(parent, name.c_str(), &by_name, AT_SYMLINK_NOFOLLOW) == 0 &&
         ::fstat(folder, &open) == 0 && is_same(by_name, open);
}

// A file system may map owners, but it maps those of one user's folder and file alike.
bool is_of_owner_of(int file, int folder) {
  struct stat made {};
  struct stat place {};
  return ::fstat(file, &made) == 0 && ::fstat(folder, &place) == 0 && made.st_uid == place.st_uid;
}

}  // namespace

// A folder that has contents is not the one that was just made. It is left as it is.
Result<NewFolder::Staging> NewFolder::make_staging(const fs::path& target) {
  constexpr int kMaxTries = 100;
  const int parent = folder_descriptor(folder_of(target));
  if (parent < 0) return unwritable_error(target, errno);
  Staging out{.parent = parent, .name = {}, .folder = FileDescriptor()};
  for (int i = 0, made = -1; made != 0; ++i) {
    out.name =
        fmt::format(".{}.{}.{}", target.filename().string(), process_mark(), random_letters());
    made = ::mkdirat(parent, out.name.c_str(), 0700);
    if (made != 0 && (errno != EEXIST || i >= kMaxTries)) return unwritable_error(target, errno);
  }
  out.folder = open_folder_in(parent, out.name);
  if (out.folder && is_empty(out.folder.number())) return out;
  if (out.folder) return exchanged_folder_error(target);
  const int error = errno;
  ::unlinkat(parent, out.name.c_str(), AT_REMOVEDIR);
  return unwritable_in_folder_error(target, {}, error);
}

Result<NewFolder> NewFolder::at(const fs::path& given) {
  NewFolder out(given.has_filename() ? given : given.parent_path());
  DDSSEC_RETURN_IF_ERROR(check_nothing_at(out.target_));
  if (writes_nothing()) return out;
  remove_unfinished_folders(out.target_);
  DDSSEC_ASSIGN_OR_RETURN(auto staging, make_staging(out.target_));
  out.staging_.emplace(std::move(staging));
  return out;
}

// Folders are created one by one, each with its final mode from the beginning.
Result<FileDescriptor> NewFolder::open_folder_of(const fs::path& name) const {
  auto at = open_folder_in(staging_->folder.number(), ".");
  for (const auto& part : name.parent_path()) {
    if (!at) break;
    const unsigned mode = part == "private" ? 0700 : 0755;
    if (::mkdirat(at.number(), part.c_str(), mode) != 0 && errno != EEXIST)
      return unwritable_in_folder_error(target_, name, errno);
    at = open_folder_in(at.number(), part);
  }
  if (!at) return unwritable_in_folder_error(target_, name, errno);
  return at;
}

Status NewFolder::create(const fs::path& name, BytesView octets, unsigned mode) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_ASSIGN_OR_RETURN(const auto folder, open_folder_of(name));
  const FilePlace at{folder.number(), name.filename()};
  auto file = open_new(at, mode);
  if (!file) return unwritable_in_folder_error(target_, name, errno);
  if (is_of_owner_of(file.number(), folder.number()))
    return write_and_close(std::move(file), at, target_ / name, octets, Flush::later);
  ::unlinkat(at.folder, at.path.c_str(), 0);
  return exchanged_folder_error(target_);
}

Status NewFolder::add(const fs::path& name, BytesView octets, unsigned mode) {
  if (staging_) {
    DDSSEC_RETURN_IF_ERROR(create(name, octets, mode));
    names_.push_back(name);
  }
  files_.push_back(written_file(target_ / name, octets, mode));
  return check_not_interrupted();
}

Status NewFolder::link(const fs::path& name, const fs::path& to) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  files_.push_back({.path = target_ / name, .mode = "link", .link_to = to});
  if (!staging_) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto folder, open_folder_of(name));
  if (::symlinkat(to.c_str(), folder.number(), name.filename().c_str()) == 0) return {};
  return unwritable_in_folder_error(target_, name, errno);
}

// A few files are flushed separately; for a fleet one call for the whole file system is much
// faster.
Status NewFolder::flush() const {
  constexpr std::size_t kFew = 32;
  if (names_.size() > kFew)
    return ::syncfs(staging_->folder.number()) == 0 ? Status() : unwritable_error(target_, errno);
  for (const auto& name : names_) {
    DDSSEC_ASSIGN_OR_RETURN(const auto folder, open_folder_of(name));
    const FileDescriptor file(::openat(folder.number(), name.filename().c_str(),
                                       O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (!file || ::fsync(file.number()) != 0)
      return unwritable_in_folder_error(target_, name, errno);
  }
  return {};
}

// The name is checked again after the rename, because it may be exchanged until then.
Status NewFolder::put_in_place() {
  const auto& [parent, name, folder, drafting] = *staging_;
  const std::string final_name = target_.filename();
  if (!is_at(parent, name, folder.number())) return exchanged_folder_error(target_);
  if (::renameat2(parent, name.c_str(), parent, final_name.c_str(), RENAME_NOREPLACE) != 0)
    return rename_failed_error(target_, errno);
  return is_at(parent, final_name, folder.number()) ? Status() : exchanged_folder_error(target_);
}

Result<std::vector<WrittenFile>> NewFolder::commit() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (!staging_) return files_;
  DDSSEC_RETURN_IF_ERROR(flush());
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  DDSSEC_RETURN_IF_ERROR(put_in_place());
  staging_.reset();
  return files_;
}

// Removes all contents of the unfinished folder, wherever it is now.
NewFolder::~NewFolder() {
  if (!staging_ || !staging_->folder) return;
  const auto& [parent, name, folder, drafting] = *staging_;
  remove_contents(folder.number());
  if (is_at(parent, name, folder.number())) ::unlinkat(parent, name.c_str(), AT_REMOVEDIR);
}

}  // namespace ddssec::cli
