#include "cli/frame/file_transaction.hpp"

#include <algorithm>
#include <cerrno>
#include <expected>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/folder_rights.hpp"
#include "cli/frame/file_lock.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/stale_drafts.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Writes a draft beside the target, in the folder that was opened first, and flushes it to the
// disk. A killed process may have left a draft with the same process number. In a container this
// happens soon, because each start may have the same number. remove_drafts_of() knows these names.
Result<fs::path> write_draft(const fs::path& target, BytesView octets, unsigned mode) {
  constexpr int kMaxTries = 100;
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  FilePlace at{folder_descriptor(folder_of(target)), {}};
  if (at.folder < 0) return unwritable_error(target, errno);
  const auto beginning = fmt::format("{}.{}", target.filename().string(), process_mark());
  at.path = beginning + ".new";
  auto file = open_new(at, mode);
  for (int i = 1; i < kMaxTries && !file && errno == EEXIST; ++i) {
    at.path = fmt::format("{}.{}.new", beginning, i);
    file = open_new(at, mode);
  }
  if (!file) return unwritable_error(target, errno);
  if (const int error = keep_owner(file.number(), at.folder, target, mode); error != 0) {
    ::unlinkat(at.folder, at.path.c_str(), 0);
    return unwritable_error(target, error);
  }
  DDSSEC_RETURN_IF_ERROR(write_and_close(std::move(file), at, target, octets, Flush::now));
  return target.parent_path() / at.path;
}

// Renames within one folder, which has been open since the draft was made. Returns 0 or errno.
int rename_draft(const Draft& draft, unsigned flags) {
  const int folder = folder_descriptor(folder_of(draft.target));
  const auto from = draft.draft.filename();
  const auto to = draft.target.filename();
  const int done = flags == 0 ? ::renameat(folder, from.c_str(), folder, to.c_str())
                              : ::renameat2(folder, from.c_str(), folder, to.c_str(), flags);
  return done == 0 ? 0 : errno;
}

void remove_draft(const Draft& draft) {
  ::unlinkat(folder_descriptor(folder_of(draft.target)), draft.draft.filename().c_str(), 0);
}

fs::path target_in_open_folder(const fs::path& target) {
  const int folder = folder_descriptor(folder_of(target));
  return fs::path(fmt::format("/proc/self/fd/{}", folder)) / target.filename();
}

// The kind of file at the target, which may be a link. 0 if there is none. Error: errno.
std::expected<mode_t, int> kind_at(const fs::path& target) {
  const int folder = folder_descriptor(folder_of(target));
  struct stat status {};
  if (folder >= 0 &&
      ::fstatat(folder, target.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0)
    return status.st_mode & S_IFMT;
  if (errno == ENOENT || errno == ENOTDIR) return 0;
  return std::unexpected(errno);
}

std::unexpected<Error> draft_lost_error(const Draft& draft) {
  return fail(Code::file_unwritable,
              {.document = draft.target,
               .note = "another user or program removed the new file before it got its place"});
}

// In a sticky folder, only a file's owner, the folder's owner and root can replace a file.
bool is_protected(int folder, const struct stat& file) {
  struct stat place {};
  const auto user = ::geteuid();
  return ::fstat(folder, &place) == 0 && is_sticky(place) && user != 0 && place.st_uid != user &&
         file.st_uid != user;
}

// Success if the draft can be renamed. The folder may belong to another user, who can change it.
Status check_can_be_put(const Draft& draft) {
  const int folder = folder_descriptor(folder_of(draft.target));
  struct stat status {};
  const auto is_at = [&](const fs::path& path) {
    return ::fstatat(folder, path.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
  };
  if (!is_at(draft.draft) || !S_ISREG(status.st_mode)) return draft_lost_error(draft);
  if (!is_at(draft.target)) return {};
  if (S_ISDIR(status.st_mode)) return unwritable_error(draft.target, EISDIR);
  return is_protected(folder, status) ? unwritable_error(draft.target, EPERM) : Status();
}

bool has_begun(const std::vector<Draft>& drafts) {
  return std::ranges::any_of(drafts, [](const auto& one) { return one.draft.empty(); });
}

bool is_waiting(const Draft& draft) {
  return ::faccessat(folder_descriptor(folder_of(draft.target)), draft.draft.filename().c_str(),
                     F_OK, AT_SYMLINK_NOFOLLOW) == 0;
}

// True if all drafts that are not in place yet still exist.
bool are_there(const std::vector<Draft>& drafts) {
  return std::ranges::all_of(drafts,
                             [](const auto& one) { return one.draft.empty() || is_waiting(one); });
}

// Call this after the commit, because until then another list may contain the drafts.
void remove_former_drafts(const std::vector<Draft>& drafts) {
  std::vector<fs::path> targets;
  for (const auto& draft : drafts) targets.push_back(target_in_open_folder(draft.target));
  remove_drafts_of(targets);
}

// The end of the last line that has a line break; -1 if the file cannot be read.
off_t end_of_last_line(int file) {
  off_t end = ::lseek(file, 0, SEEK_END);
  char last = 0;
  while (end > 0) {
    if (::pread(file, &last, 1, end - 1) != 1) return -1;
    if (last == '\n') break;
    --end;
  }
  return end;
}

// The place where lines can be added to a log.
struct EndOfLog {
  off_t at;
  bool lacks_line_end;
};

// A part of a line is never a complete JSON object. A complete last line counts and only lacks its
// line break, which an editor may have removed.
std::optional<EndOfLog> end_of_log(int file) {
  const auto end = end_of_last_line(file);
  const auto size = ::lseek(file, 0, SEEK_END);
  if (end < 0 || size < end) return std::nullopt;
  const auto length = static_cast<std::size_t>(size - end);
  if (length == 0 || length > pki::kMaxLogLineOctets) return EndOfLog{end, false};
  std::string last(length, '\0');
  if (::pread(file, last.data(), length, end) != size - end) return std::nullopt;
  const bool is_whole = Json::accept(last);
  return EndOfLog{is_whole ? size : end, is_whole};
}

bool leads_to(const fs::path& link, const fs::path& to) {
  std::error_code ignored;
  return fs::is_symlink(link, ignored) && fs::read_symlink(link, ignored) == to;
}

}  // namespace

Status check_link_place(const fs::path& target, const fs::path& to) {
  return leads_to(target, to) ? Status() : check_nothing_at(target);
}

Result<WrittenFile> write_link(const fs::path& target, const fs::path& to) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  WrittenFile out{.path = target, .mode = "link", .link_to = to};
  if (leads_to(target, to)) return out;
  DDSSEC_RETURN_IF_ERROR(check_nothing_at(target));
  if (!writes_nothing() &&
      ::symlinkat(to.c_str(), folder_descriptor(folder_of(target)), target.filename().c_str()) != 0)
    return unwritable_error(target, errno);
  return out;
}

Status FileTransaction::put(const fs::path& target, BytesView octets, unsigned mode, Links links) {
  const auto kind = kind_at(target);
  if (!kind) return unwritable_error(target, kind.error());
  const bool may_go = *kind == S_IFLNK && links == Links::replaced;
  if (*kind != 0 && *kind != S_IFREG && !may_go)
    return fail(Code::would_overwrite, {.document = target, .note = "it is not a plain file"});
  auto& folder = folders_.back();
  if (!writes_nothing()) {
    if (!drafting_) drafting_.emplace();
    DDSSEC_ASSIGN_OR_RETURN(auto draft, write_draft(target, octets, mode));
    folder.drafts.push_back({std::move(draft), target});
  }
  folder.files.push_back(written_file(target, octets, mode));
  return check_not_interrupted();
}

void FileTransaction::begin_folder(std::string name) {
  folders_.push_back({.name = std::move(name)});
}

void FileTransaction::abandon_folder() {
  for (const auto& draft : folders_.back().drafts) remove_draft(draft);
  folders_.back() = {.name = folders_.back().name};
}

std::vector<Draft> FileTransaction::all_drafts() const {
  std::vector<Draft> out;
  for (const auto& folder : folders_)
    out.insert(out.end(), folder.drafts.begin(), folder.drafts.end());
  return out;
}

Result<std::vector<WrittenFile>> FileTransaction::commit() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  const auto drafts = all_drafts();
  if (drafts.size() < 2) return put_in_place(nullptr);
  DDSSEC_ASSIGN_OR_RETURN(auto pending,
                          PendingRenames::write(folder_of(drafts.front().target), drafts));
  return put_in_place(&pending);
}

Result<std::vector<WrittenFile>> FileTransaction::commit_each() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  return put_in_place(nullptr);
}

// Checks all drafts first, so that a folder gets all of its files or none. If its owner changes it
// between the check and a rename, only some files are put in place; then the next command does the
// rest.
Status FileTransaction::put_in_place(Folder& folder) {
  for (const auto& draft : folder.drafts)
    if (!draft.draft.empty()) DDSSEC_RETURN_IF_ERROR(check_can_be_put(draft));
  for (auto& draft : folder.drafts) {
    if (draft.draft.empty()) continue;
    if (const int error = rename_draft(draft, 0); error != 0)
      return is_waiting(draft) ? unwritable_error(draft.target, error) : draft_lost_error(draft);
    draft.draft.clear();
  }
  remove_former_drafts(folder.drafts);
  return {};
}

Result<std::vector<WrittenFile>> FileTransaction::put_in_place(PendingRenames* pending) {
  const bool may_leave = pending != nullptr && pending->is_trusted();
  if (auto own = put_in_place(folders_.front()); !own) {
    if (may_leave && has_begun(folders_.front().drafts)) {
      pending->leave_for_next_command();
      folders_.clear();
    }
    return std::unexpected(std::move(own).error());
  }
  std::vector<WrittenFile> files;
  for (auto& folder : folders_) {
    if (auto put = put_in_place(folder); put) {
      files.insert(files.end(), folder.files.begin(), folder.files.end());
      continue;
    } else {
      failures_.push_back({folder.name, std::move(put).error()});
    }
    if (!may_leave || !are_there(folder.drafts)) continue;
    pending->leave_for_next_command();
    folder.drafts.clear();
  }
  return files;
}

FileTransaction::~FileTransaction() {
  for (const auto& draft : all_drafts())
    if (!draft.draft.empty()) remove_draft(draft);
}

Status append_lines(const fs::path& target, std::string_view lines, const fs::path& lock) {
  if (writes_nothing()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto held, FileLock::of(lock));
  const FileDescriptor file(
      ::open(target.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!file) return unwritable_error(target, errno);
  const auto end = end_of_log(file.number());
  if (!end || ::ftruncate(file.number(), end->at) != 0 ||
      ::lseek(file.number(), end->at, SEEK_SET) != end->at)
    return unwritable_error(target, errno);
  const auto text = (end->lacks_line_end ? "\n" : "") + std::string(lines);
  const int error = write_all(file.number(), as_bytes(text));
  if (error != 0 || ::fsync(file.number()) != 0)
    return unwritable_error(target, error ? error : errno);
  return {};
}

Result<WrittenFile> write_new_file(const fs::path& target, BytesView octets, unsigned mode) {
  DDSSEC_RETURN_IF_ERROR(check_nothing_at(target));
  if (writes_nothing()) return written_file(target, octets, mode);
  DDSSEC_ASSIGN_OR_RETURN(auto draft_file, write_draft(target, octets, mode));
  const Draft draft{std::move(draft_file), target};
  if (const int error = rename_draft(draft, RENAME_NOREPLACE); error != 0) {
    remove_draft(draft);
    return rename_failed_error(target, error);
  }
  const auto in_folder = target_in_open_folder(target);
  remove_drafts_of({&in_folder, 1});
  return written_file(target, octets, mode);
}

}  // namespace ddssec::cli
