#include "rtps/durability/store_file.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/folder_rights.hpp"

namespace ddssec::rtps {
namespace {

namespace fs = std::filesystem;

std::unexpected<Error> unusable_file_error(const std::string& path, std::string expected,
                                           std::string found) {
  return fail(Code::rtps_store_unusable,
              {.document = path, .expected = std::move(expected), .found = std::move(found)});
}

// The file has samples of secured topics in the clear, so only the process's user may read it. It
// is not repaired here, because other users may already have read or opened it.
Status check_private(const std::string& path, const struct stat& status) {
  if (!S_ISREG(status.st_mode))
    return unusable_file_error(path, "a regular file", "another kind of file");
  if (status.st_uid != ::geteuid())
    return fail(Code::rtps_store_unusable,
                {.document = path,
                 .field = "owner",
                 .expected = "user " + std::to_string(::geteuid()) + ", who runs this process",
                 .found = "user " + std::to_string(status.st_uid),
                 .hint = "name another file, or let its owner give it to that user"});
  if ((status.st_mode & 077) == 0) return {};
  return fail(Code::rtps_store_unusable,
              {.document = path,
               .field = "mode",
               .expected = "0600",
               .found = fmt::format("{:04o}", status.st_mode & 07777),
               .hint = "chmod 600 the file; other users may already have read what is in it"});
}

// SQLite adopts the contents of these files, and keeps their modes.
Status check_companions(const std::string& path) {
  for (const auto* suffix : {"-wal", "-shm", "-journal"}) {
    struct stat status {};
    const auto companion = path + suffix;
    if (::lstat(companion.c_str(), &status) != 0) continue;
    DDSSEC_RETURN_IF_ERROR(check_private(companion, status));
  }
  return {};
}

// A user who can write to the folder, or to one above it, can replace the store after the check, or
// make a file that SQLite makes next to it. So the sticky bit does not suffice for the folder.
Status check_folder(const fs::path& folder) {
  auto open = open_folder_above(folder);
  struct stat status {};
  if (!open && ::lstat(folder.c_str(), &status) == 0 && others_may_write(status)) open = folder;
  if (!open) return {};
  return fail(
      Code::rtps_store_unusable,
      {.document = *open,
       .expected = fmt::format("a folder of root or of user {}, who runs this process, in which no "
                               "other user can make files",
                               ::geteuid()),
       .found = owner_and_mode(*open),
       .hint = "put the store into a folder that only this user can write to (chmod go-w FOLDER); "
               "others could put a file of their own in its place"});
}

// The path of the store without links, so that no link is changed after the check.
Result<fs::path> path_without_links(const std::string& path) {
  std::error_code error;
  const auto folder = fs::canonical(fs::absolute(path, error).parent_path(), error);
  if (error) return unusable_file_error(path, "a file in a folder that exists", error.message());
  DDSSEC_RETURN_IF_ERROR(check_folder(folder));
  return folder / fs::path(path).filename();
}

}  // namespace

Result<std::string> make_store_file(const std::string& given) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string path, path_without_links(given));
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  const int file =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  if (file < 0) return unusable_file_error(path, "a file that can be written", errno_text(errno));
  struct stat status {};
  std::array<char, 512> head{};
  const bool is_known = ::fstat(file, &status) == 0;
  const auto size = ::read(file, head.data(), head.size());
  ::close(file);
  if (!is_known) return unusable_file_error(path, "a file with a mode", "none");
  DDSSEC_RETURN_IF_ERROR(check_private(path, status));
  DDSSEC_RETURN_IF_ERROR(check_companions(path));
  const bool ours = size == static_cast<ssize_t>(head.size()) &&
                    std::string_view(head.data(), kMagic.size()) == kMagic;
  if (size == 0 || ours) return path;
  return unusable_file_error(path, "a store of samples, or an empty file", "neither");
}

}  // namespace ddssec::rtps
