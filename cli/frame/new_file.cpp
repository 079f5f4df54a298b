#include "cli/frame/new_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/hash.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

bool dry_run = false;

}  // namespace

void write_nothing() { dry_run = true; }
bool writes_nothing() { return dry_run; }

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::unexpected<Error> unwritable_error(const fs::path& path, int error) {
  const auto folder = folder_of(path);
  std::error_code ignored;
  ErrorDetails details{.document = path, .note = errno_text(error)};
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

std::unexpected<Error> rename_failed_error(const fs::path& target, int error) {
  if (error == EEXIST || error == ENOTEMPTY)
    return fail(Code::would_overwrite, {.document = target});
  return unwritable_error(target, error);
}

Status check_nothing_at(const fs::path& path) {
  std::error_code error;
  const auto type = fs::symlink_status(path, error).type();
  if (error == std::errc::not_a_directory) return unwritable_error(path, ENOTDIR);
  if (type == fs::file_type::not_found)
    return fs::exists(folder_of(path), error) ? Status() : unwritable_error(path, ENOENT);
  // The name may be too long, or the folder may not be accessible.
  if (type == fs::file_type::none) return unwritable_error(path, error.value());
  return fail(Code::would_overwrite, {.document = path});
}

FileDescriptor open_new(const FilePlace& at, unsigned mode) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW;
  return FileDescriptor(::openat(at.folder, at.path.c_str(), kFlags, mode));
}

int write_all(int file, BytesView octets) {
  while (!octets.empty()) {
    const auto written = ::write(file, octets.data(), octets.size());
    if (written < 0 && errno != EINTR) return errno;
    if (written > 0) octets = octets.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

Status write_and_close(FileDescriptor file, const FilePlace& at, const fs::path& meant,
                       BytesView octets, Flush flush) {
  int error = write_all(file.number(), octets);
  if (error == 0 && flush == Flush::now && ::fsync(file.number()) != 0) error = errno;
  if (::close(file.release()) == 0 && error == 0) return {};
  ::unlinkat(at.folder, at.path.c_str(), 0);
  return unwritable_error(meant, error != 0 ? error : EIO);
}

WrittenFile written_file(const fs::path& path, BytesView octets, unsigned mode) {
  return {.path = path,
          .mode = fmt::format("{:04o}", mode),
          .sha256 = to_hex(sha256(octets)),
          .link_to = {}};
}

}  // namespace ddssec::cli
