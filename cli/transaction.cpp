#include "cli/transaction.hpp"

#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/hash.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t interrupted_by = 0;
void remember(int signal) { interrupted_by = signal; }

std::unexpected<Error> unwritable(const fs::path& path, int error) {
  return fail(Code::file_unwritable,
              {.document = path, .note = std::generic_category().message(error)});
}

std::unexpected<Error> rename_failed(const fs::path& target, int error) {
  if (error == EEXIST || error == ENOTEMPTY)
    return fail(Code::would_overwrite, {.document = target});
  return unwritable(target, error);
}

bool exists_at_all(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() != fs::file_type::not_found;
}

int write_all(int file, BytesView octets) {
  while (!octets.empty()) {
    const auto written = ::write(file, octets.data(), octets.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) octets = octets.subspan(static_cast<std::size_t>(written));
  }
  return ::fsync(file) == 0 ? 0 : errno;
}

Status write_exclusively(const fs::path& path, BytesView octets, unsigned mode) {
  DDSSEC_TRY(check_not_interrupted());
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
  if (file < 0) return unwritable(path, errno);
  const int error = write_all(file, octets);
  if (::close(file) == 0 && error == 0) return {};
  ::unlink(path.c_str());
  return unwritable(path, error != 0 ? error : EIO);
}

WrittenFile written(const fs::path& path, BytesView octets, unsigned mode) {
  return {path, fmt::format("{:04o}", mode), to_hex(sha256(octets))};
}

}  // namespace

Status check_not_interrupted() { return interrupted_by == 0 ? Status() : fail(Code::interrupted); }

void note_interruptions() {
  struct sigaction action {};
  action.sa_handler = remember;  // no SA_RESTART: a prompt for a passphrase ends as well
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(signal, &action, nullptr);
}

Result<NewFolder> NewFolder::at(const fs::path& given) {
  const fs::path target = given.has_filename() ? given : given.parent_path();
  if (exists_at_all(target)) return fail(Code::would_overwrite, {.document = target});
  auto staging =
      (target.parent_path() / fmt::format(".{}.XXXXXX", target.filename().string())).string();
  if (::mkdtemp(staging.data()) == nullptr) return unwritable(target, errno);
  return NewFolder(target, staging);
}

Status NewFolder::add(const fs::path& name, BytesView octets, unsigned mode) {
  std::error_code error;
  fs::create_directories((staging_ / name).parent_path(), error);
  if (error) return unwritable(target_ / name, error.value());
  DDSSEC_TRY(write_exclusively(staging_ / name, octets, mode));
  files_.push_back(written(target_ / name, octets, mode));
  return {};
}

Result<std::vector<WrittenFile>> NewFolder::commit() {
  DDSSEC_TRY(check_not_interrupted());
  if (::renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), RENAME_NOREPLACE) != 0)
    return rename_failed(target_, errno);
  staging_.clear();
  return files_;
}

NewFolder::~NewFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

NewFolder::NewFolder(NewFolder&& other) noexcept
    : target_(std::move(other.target_)),
      staging_(std::exchange(other.staging_, {})),
      files_(std::move(other.files_)) {}

Result<WrittenFile> write_new_file(const fs::path& target, BytesView octets, unsigned mode) {
  if (exists_at_all(target)) return fail(Code::would_overwrite, {.document = target});
  const fs::path draft = fmt::format("{}.{}.new", target.string(), ::getpid());
  const auto drafted = write_exclusively(draft, octets, mode);
  const bool placed = drafted && ::renameat2(AT_FDCWD, draft.c_str(), AT_FDCWD, target.c_str(),
                                             RENAME_NOREPLACE) == 0;
  const int error = errno;
  if (!placed && drafted) ::unlink(draft.c_str());
  if (!drafted) return std::unexpected(drafted.error());
  if (!placed) return rename_failed(target, error);
  return written(target, octets, mode);
}

}  // namespace ddssec::cli
