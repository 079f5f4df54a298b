#include "cli/transaction.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <expected>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <sys/time.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "cli/file_lock.hpp"
#include "cli/held_folder.hpp"
#include "cli/leftovers.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t interrupted_by = 0;
// The number of folders and sets of files that are drafted, and neither in place nor removed.
std::atomic<int> unfinished = 0;
static_assert(std::atomic<int>::is_always_lock_free);
constexpr itimerval kTimeToNotice = {.it_interval = {}, .it_value = {0, 200'000}};

// setitimer is a bare system call on Linux: safe in a handler.
void await_notice() { ::setitimer(ITIMER_REAL, &kTimeToNotice, nullptr); }

void remember(int signal) {
  await_notice();
  interrupted_by = signal;
}

// A command that only computes does not check for interruptions. One that writes does, at each
// file, and removes its drafts.
void end_unless_writing(int) {
  if (unfinished != 0) return await_notice();
  ::signal(interrupted_by, SIG_DFL);
  ::raise(interrupted_by);
}

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

std::unexpected<Error> rename_failed(const fs::path& target, int error) {
  if (error == EEXIST || error == ENOTEMPTY)
    return fail(Code::would_overwrite, {.document = target});
  return unwritable(target, error);
}

}  // namespace

std::unexpected<Error> unwritable(const fs::path& path, int error) {
  const auto folder = folder_of(path);
  std::error_code ignored;
  ErrorDetails details{.document = path, .note = std::generic_category().message(error)};
  if (error == ENOENT && !fs::exists(folder, ignored)) {
    details.note = fmt::format("the folder {} does not exist", folder.string());
    details.hint =
        fmt::format("make it first: mkdir -p {}; or choose another place", folder.string());
  } else if (error == ENOTDIR) {
    details.note = fmt::format("{} is not a folder", folder.string());
    details.hint = "choose a place in a folder";
  }
  return fail(Code::file_unwritable, std::move(details));
}

Status check_nothing_at(const fs::path& path) {
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  if (error == std::errc::not_a_directory) return unwritable(path, ENOTDIR);
  if (type == fs::file_type::not_found)
    return fs::exists(folder_of(path), error) ? Status() : unwritable(path, ENOENT);
  // For example a name that is too long, or a folder that cannot be entered.
  if (type == fs::file_type::none) return unwritable(path, error.value());
  return fail(Code::would_overwrite, {.document = path});
}

namespace {

bool dry_run = false;

/// A file descriptor that closes itself.
class File {
 public:
  File(const fs::path& path, int flags, unsigned mode = 0)
      : number_(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW, mode)) {}
  ~File() {
    if (number_ >= 0) ::close(number_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  explicit operator bool() const { return number_ >= 0; }
  int number() const { return number_; }

 private:
  int number_;
};

int write_all(int file, BytesView octets) {
  while (!octets.empty()) {
    const auto written = ::write(file, octets.data(), octets.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) octets = octets.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

enum class Flush : std::uint8_t { now, later };

/// A path by which a file can be reached: from `folder`, a descriptor, if it is relative.
struct Place {
  int folder;
  std::string path;
};

int open_new(const Place& at, unsigned mode) {
  return ::openat(at.folder, at.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW,
                  mode);
}

// Writes to an open file and closes it. Errors name the final file.
Status write_and_close(int file, const Place& at, const fs::path& meant, BytesView octets,
                       Flush flush) {
  int error = write_all(file, octets);
  if (error == 0 && flush == Flush::now && ::fsync(file) != 0) error = errno;
  if (::close(file) == 0 && error == 0) return {};
  ::unlinkat(at.folder, at.path.c_str(), 0);
  return unwritable(meant, error != 0 ? error : EIO);
}

Status write_exclusively(const fs::path& path, const fs::path& meant, BytesView octets,
                         unsigned mode, Flush flush) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  const Place at{AT_FDCWD, path.string()};
  const int file = open_new(at, mode);
  if (file < 0) return unwritable(meant, errno);
  return write_and_close(file, at, meant, octets, flush);
}

// Writes a draft beside the target, in the folder that was opened first, and flushes it to the
// disk. A killed process may have left a draft with the same process number; this happens soon in a
// container, where each start may have the same number. remove_drafts_of() knows these names.
Result<fs::path> write_draft(const fs::path& target, BytesView octets, unsigned mode) {
  constexpr int kMostTries = 100;
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  Place at{folder_descriptor(folder_of(target)), {}};
  if (at.folder < 0) return unwritable(target, errno);
  const auto beginning = fmt::format("{}.{}", target.filename().string(), process_mark());
  at.path = beginning + ".new";
  int file = open_new(at, mode);
  for (int i = 1; i < kMostTries && file < 0 && errno == EEXIST; ++i) {
    at.path = fmt::format("{}.{}.new", beginning, i);
    file = open_new(at, mode);
  }
  if (file < 0) return unwritable(target, errno);
  if (const int error = keep_owner(file, at.folder, target, mode); error != 0) {
    ::close(file);
    ::unlinkat(at.folder, at.path.c_str(), 0);
    return unwritable(target, error);
  }
  DDSSEC_RETURN_IF_ERROR(write_and_close(file, at, target, octets, Flush::now));
  return target.parent_path() / at.path;
}

// Both are in one folder, which is open since the draft was made. 0 or the number in errno.
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

// The kind of file at the target, which may be a link: 0 if there is none. Error: errno.
std::expected<mode_t, int> kind_at(const fs::path& target) {
  const int folder = folder_descriptor(folder_of(target));
  struct stat status {};
  if (folder >= 0 &&
      ::fstatat(folder, target.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0)
    return status.st_mode & S_IFMT;
  if (errno == ENOENT || errno == ENOTDIR) return 0;
  return std::unexpected(errno);
}

std::unexpected<Error> draft_lost(const Draft& draft) {
  return fail(Code::file_unwritable,
              {.document = draft.target,
               .note = "another user or program removed the new file before it got its place"});
}

// In a sticky folder, only a file's owner, the folder's owner and root can replace a file.
bool is_protected(int folder, const struct stat& file) {
  struct stat place {};
  const auto user = ::geteuid();
  return ::fstat(folder, &place) == 0 && (place.st_mode & S_ISVTX) != 0 && user != 0 &&
         place.st_uid != user && file.st_uid != user;
}

// The folder may be another user's.
Status check_can_be_put(const Draft& draft) {
  const int folder = folder_descriptor(folder_of(draft.target));
  struct stat status {};
  const auto is_at = [&](const fs::path& path) {
    return ::fstatat(folder, path.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
  };
  if (!is_at(draft.draft) || !S_ISREG(status.st_mode)) return draft_lost(draft);
  if (!is_at(draft.target)) return {};
  if (S_ISDIR(status.st_mode)) return unwritable(draft.target, EISDIR);
  return is_protected(folder, status) ? unwritable(draft.target, EPERM) : Status();
}

bool has_begun(const std::vector<Draft>& drafts) {
  return std::ranges::any_of(drafts, [](const auto& one) { return one.draft.empty(); });
}

bool is_waiting(const Draft& draft) {
  return ::faccessat(folder_descriptor(folder_of(draft.target)), draft.draft.filename().c_str(),
                     F_OK, AT_SYMLINK_NOFOLLOW) == 0;
}

// Those that are not in place yet.
bool are_there(const std::vector<Draft>& drafts) {
  return std::ranges::all_of(drafts,
                             [](const auto& one) { return one.draft.empty() || is_waiting(one); });
}

// Called after the commit, because until then another list may contain them.
void remove_former_drafts(const std::vector<Draft>& drafts) {
  std::vector<fs::path> targets;
  for (const auto& draft : drafts) targets.push_back(target_in_open_folder(draft.target));
  remove_drafts_of(targets);
}

// Where the last whole line of a file ends; -1 if it cannot be read.
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

WrittenFile written(const fs::path& path, BytesView octets, unsigned mode) {
  return {.path = path,
          .mode = fmt::format("{:04o}", mode),
          .sha256 = to_hex(sha256(octets)),
          .link_to = {}};
}

}  // namespace

Status check_not_interrupted() {
  if (interrupted_by == 0) return {};
  constexpr itimerval kNever = {};
  ::setitimer(ITIMER_REAL, &kNever, nullptr);  // the command ends by itself
  return fail(Code::interrupted);
}

void note_interruptions() {
  struct sigaction action {};
  action.sa_handler = remember;  // no SA_RESTART: a prompt for a passphrase ends as well
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(signal, &action, nullptr);
  action.sa_handler = end_unless_writing;
  ::sigaction(SIGALRM, &action, nullptr);
}

void write_nothing() { dry_run = true; }
bool writes_nothing() { return dry_run; }

Result<NewFolder> NewFolder::at(const fs::path& given) {
  const fs::path target = given.has_filename() ? given : given.parent_path();
  DDSSEC_RETURN_IF_ERROR(check_nothing_at(target));
  if (dry_run) return NewFolder(target, {});
  remove_unfinished_folders(target);
  auto staging = (target.parent_path() /
                  fmt::format(".{}.{}.XXXXXX", target.filename().string(), process_mark()))
                     .string();
  ++unfinished;
  if (::mkdtemp(staging.data()) == nullptr) {
    const int error = errno;
    --unfinished;
    return unwritable(target, error);
  }
  return NewFolder(target, staging);
}

// Folders are made one by one, with their final mode from the beginning.
Status NewFolder::make_parent(const fs::path& name) {
  fs::path at = staging_;
  for (const auto& part : name.parent_path()) {
    at /= part;
    const unsigned mode = part == "private" ? 0700 : 0755;
    if (::mkdir(at.c_str(), mode) != 0 && errno != EEXIST) return unwritable(target_ / name, errno);
  }
  return {};
}

Status NewFolder::add(const fs::path& name, BytesView octets, unsigned mode) {
  if (!dry_run) {
    DDSSEC_RETURN_IF_ERROR(make_parent(name));
    DDSSEC_RETURN_IF_ERROR(
        write_exclusively(staging_ / name, target_ / name, octets, mode, Flush::later));
    drafts_.push_back(staging_ / name);
  }
  files_.push_back(written(target_ / name, octets, mode));
  return check_not_interrupted();
}

Status NewFolder::link(const fs::path& name, const fs::path& to) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  files_.push_back({.path = target_ / name, .mode = "link", .link_to = to});
  if (dry_run) return {};
  DDSSEC_RETURN_IF_ERROR(make_parent(name));
  if (::symlink(to.c_str(), (staging_ / name).c_str()) != 0)
    return unwritable(target_ / name, errno);
  return {};
}

// A few files are flushed separately; for a fleet one call for the whole file system is much
// faster.
Status NewFolder::flush() const {
  constexpr std::size_t kFew = 32;
  if (drafts_.size() > kFew) {
    const File folder(staging_, O_RDONLY | O_DIRECTORY);
    return folder && ::syncfs(folder.number()) == 0 ? Status() : unwritable(target_, errno);
  }
  for (const auto& draft : drafts_) {
    const File file(draft, O_RDONLY);
    if (!file || ::fsync(file.number()) != 0) return unwritable(target_, errno);
  }
  return {};
}

Result<std::vector<WrittenFile>> NewFolder::commit() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (dry_run) return files_;
  DDSSEC_RETURN_IF_ERROR(flush());
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (::renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), RENAME_NOREPLACE) != 0)
    return rename_failed(target_, errno);
  staging_.clear();
  --unfinished;
  return files_;
}

NewFolder::~NewFolder() {
  if (staging_.empty()) return;
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  --unfinished;
}

NewFolder::NewFolder(NewFolder&& other) noexcept
    : target_(std::move(other.target_)),
      staging_(std::exchange(other.staging_, {})),
      drafts_(std::move(other.drafts_)),
      files_(std::move(other.files_)) {}

namespace {

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
  if (!dry_run && ::symlink(to.c_str(), target.c_str()) != 0) return unwritable(target, errno);
  return out;
}

Status Replacement::put(const fs::path& target, BytesView octets, unsigned mode, Links links) {
  const auto kind = kind_at(target);
  if (!kind) return unwritable(target, kind.error());
  const bool may_go = *kind == S_IFLNK && links == Links::replaced;
  if (*kind != 0 && *kind != S_IFREG && !may_go)
    return fail(Code::would_overwrite, {.document = target, .note = "it is not a plain file"});
  auto& folder = folders_.back();
  if (!dry_run) {
    if (!std::exchange(has_drafts_, true)) ++unfinished;
    DDSSEC_ASSIGN_OR_RETURN(auto draft, write_draft(target, octets, mode));
    folder.drafts.push_back({std::move(draft), target});
  }
  folder.files.push_back(written(target, octets, mode));
  return check_not_interrupted();
}

void Replacement::begin_folder(std::string name) { folders_.push_back({.name = std::move(name)}); }

void Replacement::abandon_folder() {
  for (const auto& draft : folders_.back().drafts) remove_draft(draft);
  folders_.back() = {.name = folders_.back().name};
}

std::vector<Draft> Replacement::all_drafts() const {
  std::vector<Draft> out;
  for (const auto& folder : folders_)
    out.insert(out.end(), folder.drafts.begin(), folder.drafts.end());
  return out;
}

Result<std::vector<WrittenFile>> Replacement::commit() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  const auto drafts = all_drafts();
  if (drafts.size() < 2) return put_in_place(nullptr);
  DDSSEC_ASSIGN_OR_RETURN(auto intent, Intent::write(folder_of(drafts.front().target), drafts));
  return put_in_place(&intent);
}

Result<std::vector<WrittenFile>> Replacement::commit_each() {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  return put_in_place(nullptr);
}

// Checks first, so that a folder gets all of its files or none. Changes by its owner between the
// check and a rename can still stop this half way; then the next command does the rest.
Status Replacement::put_in_place(Folder& folder) {
  for (const auto& draft : folder.drafts)
    if (!draft.draft.empty()) DDSSEC_RETURN_IF_ERROR(check_can_be_put(draft));
  for (auto& draft : folder.drafts) {
    if (draft.draft.empty()) continue;
    if (const int error = rename_draft(draft, 0); error != 0)
      return is_waiting(draft) ? unwritable(draft.target, error) : draft_lost(draft);
    draft.draft.clear();
  }
  remove_former_drafts(folder.drafts);
  return {};
}

Result<std::vector<WrittenFile>> Replacement::put_in_place(Intent* intent) {
  const bool may_leave = intent != nullptr && intent->is_believed();
  if (auto own = put_in_place(folders_.front()); !own) {
    if (may_leave && has_begun(folders_.front().drafts)) {
      intent->keep();
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
    intent->keep();
    folder.drafts.clear();
  }
  return files;
}

Replacement::~Replacement() {
  for (const auto& draft : all_drafts())
    if (!draft.draft.empty()) remove_draft(draft);
  if (has_drafts_) --unfinished;
}

Status append_lines(const fs::path& target, std::string_view lines, const fs::path& lock) {
  if (dry_run) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto held, FileLock::of(lock));
  const File file(target, O_RDWR | O_CREAT, 0644);
  if (!file) return unwritable(target, errno);
  const auto end = end_of_last_line(file.number());
  if (end < 0 || ::ftruncate(file.number(), end) != 0 ||
      ::lseek(file.number(), end, SEEK_SET) != end)
    return unwritable(target, errno);
  const int error = write_all(file.number(), as_bytes(lines));
  if (error != 0 || ::fsync(file.number()) != 0) return unwritable(target, error ? error : errno);
  return {};
}

Result<WrittenFile> write_new_file(const fs::path& target, BytesView octets, unsigned mode) {
  DDSSEC_RETURN_IF_ERROR(check_nothing_at(target));
  if (dry_run) return written(target, octets, mode);
  DDSSEC_ASSIGN_OR_RETURN(auto draft_file, write_draft(target, octets, mode));
  const Draft draft{std::move(draft_file), target};
  if (const int error = rename_draft(draft, RENAME_NOREPLACE); error != 0) {
    remove_draft(draft);
    return rename_failed(target, error);
  }
  const auto in_folder = target_in_open_folder(target);
  remove_drafts_of({&in_folder, 1});
  return written(target, octets, mode);
}

}  // namespace ddssec::cli
