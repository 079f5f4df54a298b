#include "cli/unfinished.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "cli/transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kListName = ".ddssec-unfinished";
constexpr std::string_view kEnd("end\0", 4);  // of a list that is whole

std::unexpected<Error> cannot_write(const fs::path& path) {
  return fail(Code::file_unwritable,
              {.document = path, .note = std::generic_category().message(errno)});
}

// "target NUL ending NUL" for each.
std::string text_of(std::span<const Draft> drafts) {
  std::string out;
  std::error_code ignored;
  for (const auto& [draft, target] : drafts) {
    out.append(fs::absolute(target, ignored).string()).push_back('\0');
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
  constexpr std::size_t kMostOctets = 16 * 1024 * 1024;
  std::string out;
  std::array<char, 4096> part{};
  ssize_t size = 0;
  while (out.size() < kMostOctets && (size = ::read(file, part.data(), part.size())) > 0)
    out.append(part.data(), static_cast<std::size_t>(size));
  return out;
}

std::string_view next_part(std::string_view& rest) {
  const auto end = rest.find('\0');
  const auto out = rest.substr(0, end);
  rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
  return out;
}

// Whatever a list says, no other file than a draft is moved, and only to the place beside it.
bool is_ending(std::string_view ending) {
  return ending.starts_with('.') && ending.ends_with(".new") &&
         ending.substr(0, ending.size() - 3).find_first_not_of(".0123456789") == ending.npos;
}

Status put_in_place(std::string_view list) {
  if (!list.ends_with(kEnd)) return {};  // cut short: nothing had been put in place yet
  list.remove_suffix(kEnd.size());
  while (!list.empty()) {
    const auto target = next_part(list);
    const auto ending = next_part(list);
    if (target.empty() || !is_ending(ending)) continue;
    const auto draft = std::string(target).append(ending);
    if (::rename(draft.c_str(), std::string(target).c_str()) != 0 && errno != ENOENT)
      return cannot_write(target);
  }
  return {};
}

// After the wait for its lock: it may be gone by now.
bool is_still_there(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 && status.st_nlink > 0;
}

}  // namespace

Result<Intent> Intent::write(const fs::path& folder, std::span<const Draft> drafts) {
  DDSSEC_TRY(finish_interrupted(folder));
  Intent out(folder / kListName, ::open((folder / kListName).c_str(),
                                        O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  const bool is_written =
      out.file_ >= 0 && ::flock(out.file_, LOCK_EX) == 0 && write_whole(out.file_, text_of(drafts));
  if (!is_written) return cannot_write(folder / kListName);
  return out;
}

Intent::~Intent() {
  if (file_ < 0) return;
  ::unlink(list_.c_str());
  ::close(file_);
}

Intent::Intent(Intent&& other) noexcept
    : list_(std::move(other.list_)), file_(std::exchange(other.file_, -1)) {}

Status finish_interrupted(const fs::path& folder) {
  if (writes_nothing()) return {};
  const auto list = (folder.empty() ? fs::path(".") : folder) / kListName;
  const int file = ::open(list.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return {};
  Status out;
  if (::flock(file, LOCK_EX) == 0 && is_still_there(file)) {
    out = put_in_place(content_of(file));
    if (out) ::unlink(list.c_str());
  }
  ::close(file);
  return out;
}

}  // namespace ddssec::cli
