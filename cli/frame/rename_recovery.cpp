#include "cli/frame/rename_recovery.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/file_descriptor.hpp"
#include "base/folder_rights.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/file_lock.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/notices.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kListName = ".ddssec-unfinished";
constexpr std::chrono::seconds kListTimeout{10};  // a list exists only during the renames
constexpr std::string_view kEnd("end\0", 4);      // the end of a complete list

std::unexpected<Error> unwritable_error(const fs::path& path) {
  return fail(Code::file_unwritable, {.document = path, .note = errno_text(errno)});
}

std::unexpected<Error> untrusted_list_error(const fs::path& list, std::string why) {
  return fail(Code::unfinished_untrusted, {.document = list, .found = std::move(why)});
}

int open_folder(const fs::path& folder) {
  return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

bool is_in(const fs::path& folder, const fs::path& target) {
  return target.parent_path() == (folder == "." ? fs::path() : folder) ||
         target.parent_path() == folder;
}

// Writes "target NUL ending NUL" for each draft. A file of the folder is named by its name, any
// other file by its whole path.
std::string text_of(const fs::path& folder, std::span<const Draft> drafts) {
  std::string out;
  std::error_code ignored;
  for (const auto& [draft, target] : drafts) {
    const auto name = is_in(folder, target) ? target.filename() : fs::absolute(target, ignored);
    out.append(name.string()).push_back('\0');
    out.append(draft.string().substr(target.string().size())).push_back('\0');
  }
  return out.append(kEnd);
}

bool write_whole(int file, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(file, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(file) == 0;
}

std::string content_of(int file) {
  constexpr std::size_t kMax = 16 * 1024 * 1024;
  std::string out;
  std::array<char, 4096> part{};
  ssize_t size = 0;
  while (out.size() < kMax && (size = ::read(file, part.data(), part.size())) > 0)
    out.append(part.data(), static_cast<std::size_t>(size));
  return out;
}

std::string_view next_part(std::string_view& rest) {
  const auto end = rest.find('\0');
  const auto out = rest.substr(0, end);
  rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
  return out;
}

// True for the suffix of a draft, such as ".17.3.new". A list may be forged, so a file with any
// other suffix is never renamed.
bool is_draft_suffix(std::string_view ending) {
  return ending.starts_with('.') && ending.ends_with(".new") &&
         ending.substr(0, ending.size() - 3).find_first_not_of(".0123456789") == ending.npos;
}

// A line of a list.
struct Entry {
  fs::path target;
  std::string ending;
};

// Empty for a list that was cut short, because then nothing had been put in place yet.
std::vector<Entry> entries_of(std::string_view text) {
  std::vector<Entry> out;
  if (!text.ends_with(kEnd)) return out;
  text.remove_suffix(kEnd.size());
  while (!text.empty()) {
    const fs::path target = next_part(text);
    const auto ending = next_part(text);
    if (target.has_filename() && is_draft_suffix(ending))
      out.push_back({target, std::string(ending)});
  }
  return out;
}

bool is_own(const struct stat& status) {
  return status.st_uid == ::geteuid() || status.st_uid == 0;
}

bool is_plain(const struct stat& status) { return S_ISREG(status.st_mode) && status.st_nlink == 1; }

// The reason why the list is not trusted. Empty if it belongs to this user. In a sticky folder only
// the owner of a file can replace it.
std::string doubt_about(int folder, int list) {
  struct stat place {};
  struct stat file {};
  if (::fstat(folder, &place) != 0 || ::fstat(list, &file) != 0) return "a file that is gone";
  if (!is_own(place)) return fmt::format("a folder of user {}", place.st_uid);
  if (others_may_write(place) && !is_sticky(place))
    return fmt::format("a folder that others may write, mode {:04o}", place.st_mode & 07777);
  if (!is_own(file)) return fmt::format("a list of user {}", file.st_uid);
  if (!is_plain(file)) return "no plain file, or one with further names";
  if (others_may_write(file))
    return fmt::format("a list that others may write, mode {:04o}", file.st_mode & 07777);
  return {};
}

// A list that belongs to this user.
struct List {
  fs::path path;
  int folder;
  Reach reach;

  // Both lookups use one open folder, so that no link in a path redirects the second one.
  Status put_in_place(int in, const std::string& name, std::string_view ending) const {
    const auto draft = std::string(name).append(ending);
    struct stat status {};
    // The file was put in place before.
    if (::fstatat(in, draft.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return {};
    if (!is_plain(status) || !is_own(status))
      return untrusted_list_error(path, "a draft of another user");
    if (::renameat(in, draft.c_str(), in, name.c_str()) != 0) return unwritable_error(name);
    return {};
  }

  Status put_in_place(const Entry& entry) const {
    return put_in_place(folder, entry.target.string(), entry.ending);
  }

  // The folder's owner may prevent this, or may have replaced the draft. Returns false if the draft
  // stays on the list.
  bool put_elsewhere(const Entry& entry) const {
    const FileDescriptor parent(open_folder(entry.target.parent_path()));
    if (!parent) return errno == ENOENT || errno == ENOTDIR;
    const auto put = put_in_place(parent.number(), entry.target.filename().string(), entry.ending);
    if (put || put.error().code() == Code::unfinished_untrusted) return true;
    add_notice(Error(tool_code::unfinished_left,
                     {.document = entry.target, .note = put.error().details().note}));
    return false;
  }

  // Returns the entries that could not be put in place.
  Result<std::vector<Entry>> finish(std::string_view text) const {
    std::vector<Entry> left;
    for (auto& entry : entries_of(text)) {
      if (!entry.target.has_parent_path())
        DDSSEC_RETURN_IF_ERROR(put_in_place(entry));
      else if (reach == Reach::folder)
        return untrusted_list_error(path, "a file of another folder in it");
      else if (!put_elsewhere(entry))
        left.push_back(std::move(entry));
    }
    return left;
  }
};

// The list may have been removed during the wait for its lock.
bool is_still_there(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 && status.st_nlink > 0;
}

Status check_trusted(const List& list, int file) {
  auto doubt = doubt_about(list.folder, file);
  if (doubt.empty() || !is_still_there(file)) return {};
  return untrusted_list_error(list.path, std::move(doubt));
}

Reach reach_of(const fs::path& folder, std::span<const Draft> drafts) {
  const bool is_inside =
      std::ranges::all_of(drafts, [&](const auto& one) { return is_in(folder, one.target); });
  return is_inside ? Reach::folder : Reach::anywhere;
}

// The remaining entries of a list. If there is a newer draft for a file, the older one is removed.
std::vector<Draft> remaining_drafts(std::vector<Entry> left, std::span<const Draft> drafts) {
  std::vector<Draft> out;
  std::error_code ignored;
  for (auto& [target, ending] : left) {
    fs::path draft = target.string() + ending;
    const bool is_newer = std::ranges::any_of(drafts, [&](const auto& one) {
      return fs::absolute(one.target, ignored).lexically_normal() == target.lexically_normal();
    });
    if (is_newer)
      fs::remove(draft, ignored);
    else
      out.push_back({std::move(draft), std::move(target)});
  }
  return out;
}

// Waits for a process that still holds the list. Returns the entries that are left.
Result<std::vector<Entry>> finish_list(const fs::path& given, Reach reach) {
  const fs::path at = given.empty() ? fs::path(".") : given;
  const FileDescriptor folder(open_folder(at));
  if (!folder) return std::vector<Entry>();
  const FileDescriptor file(
      ::openat(folder.number(), kListName, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file || !is_still_there(file.number())) return std::vector<Entry>();
  const List list{at / kListName, folder.number(), reach};
  // The owner is checked first, because another user may hold a lock on their own file forever.
  DDSSEC_RETURN_IF_ERROR(check_trusted(list, file.number()));
  DDSSEC_RETURN_IF_ERROR(lock_file(file.number(), list.path, kListTimeout));
  if (!is_still_there(file.number())) return std::vector<Entry>();
  DDSSEC_RETURN_IF_ERROR(check_trusted(list, file.number()));
  DDSSEC_ASSIGN_OR_RETURN(auto left, list.finish(content_of(file.number())));
  if (left.empty()) ::unlinkat(folder.number(), kListName, 0);
  return left;
}

}  // namespace

Result<PendingRenames> PendingRenames::write(const fs::path& folder,
                                             std::span<const Draft> drafts) {
  DDSSEC_ASSIGN_OR_RETURN(auto left, finish_list(folder, reach_of(folder, drafts)));
  const bool has_left = !left.empty();
  auto all = remaining_drafts(std::move(left), drafts);
  all.insert(all.end(), drafts.begin(), drafts.end());
  const int at = folder_descriptor(folder);
  if (has_left) ::unlinkat(at, kListName, 0);
  PendingRenames out(
      at, ::openat(at, kListName, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  const bool is_written = out.file_ >= 0 && ::flock(out.file_, LOCK_EX) == 0 &&
                          write_whole(out.file_, text_of(folder, all));
  if (!is_written) return unwritable_error(folder / kListName);
  out.is_kept_ = all.size() > drafts.size();
  return out;
}

bool PendingRenames::is_trusted() const { return doubt_about(folder_, file_).empty(); }

PendingRenames::~PendingRenames() {
  if (file_ < 0) return;
  if (!is_kept_) ::unlinkat(folder_, kListName, 0);
  ::close(file_);
}

PendingRenames::PendingRenames(PendingRenames&& other) noexcept
    : folder_(other.folder_), file_(std::exchange(other.file_, -1)), is_kept_(other.is_kept_) {}

Status finish_interrupted(const fs::path& folder, Reach reach) {
  if (!writes_nothing()) DDSSEC_RETURN_IF_ERROR(finish_list(folder, reach));
  return {};
}

}  // namespace ddssec::cli
