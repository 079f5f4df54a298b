#include "base/guarded_path.hpp"

#include <array>
#include <cerrno>
#include <climits>
#include <deque>
#include <fcntl.h>
#include <optional>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/folder_rights.hpp"
#include "base/tool_code.hpp"

namespace ddssec {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxLinks = 40;  // the limit of Linux
constexpr int kEnter = O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;

// A user trusts the members of their own group. Root trusts no group, so for root write permission
// of the group counts too.
bool is_writable_for_others(const struct stat& status) {
  const mode_t others = ::geteuid() == 0 ? 022 : 002;
  return (status.st_mode & others) != 0;
}

std::deque<std::string> names_of(const fs::path& path) {
  std::deque<std::string> out;
  for (const auto& name : path.relative_path())
    if (!name.empty() && name != ".") out.push_back(name);
  return out;
}

std::optional<std::string> target_of(int link) {
  std::array<char, PATH_MAX> text{};
  const auto size = ::readlinkat(link, "", text.data(), text.size());
  if (size <= 0 || static_cast<std::size_t>(size) == text.size()) return std::nullopt;
  return std::string(text.data(), static_cast<std::size_t>(size));
}

// Enters the folders of a path one after the other.
class GuardedWalk {
 public:
  explicit GuardedWalk(fs::path given) : given_(std::move(given)), rest_(names_of(given_)) {}

  Result<FileDescriptor> open(int flags) {
    start();
    while (at_ && rest_.size() > 1) {
      DDSSEC_ASSIGN_OR_RETURN(const bool is_done, step());
      if (!is_done) return FileDescriptor();
    }
    if (!at_) return FileDescriptor();
    const auto last = rest_.empty() ? "." : rest_.front();
    return FileDescriptor(
        ::openat(at_.number(), last.c_str(), flags | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  }

  // True if no other user can change what the names entered so far lead to.
  bool is_guarded() const { return is_guarded_; }

 private:
  void start() {
    if (given_.is_absolute()) return enter_root();
    at_ = FileDescriptor(::open(".", kEnter));
    is_guarded_ = at_ && is_working_folder_guarded();
  }

  void enter_root() {
    is_guarded_ = true;
    enter(FileDescriptor(::open("/", kEnter)));
  }

  bool is_working_folder_guarded() const {
    std::error_code error;
    const auto path = fs::current_path(error);
    if (error || !path.is_absolute()) return false;
    GuardedWalk above(path);
    const auto found = above.open(O_PATH);
    struct stat by_path {
    }, open{};
    return found && *found && above.is_guarded() && ::fstat(found->number(), &by_path) == 0 &&
           ::fstat(at_.number(), &open) == 0 && by_path.st_ino == open.st_ino &&
           by_path.st_dev == open.st_dev && is_closed(open);
  }

  static bool is_closed(const struct stat& status) {
    return is_of_trusted_owner(status) && (!is_writable_for_others(status) || is_sticky(status));
  }

  void enter(FileDescriptor folder) {
    struct stat status {};
    if (folder && ::fstat(folder.number(), &status) != 0) folder = FileDescriptor();
    is_guarded_ = is_guarded_ && is_closed(status);
    at_ = std::move(folder);
  }

  // Enters the next folder, or follows the next link. Returns false if the system refuses.
  Result<bool> step() {
    const auto name = rest_.front();
    if (FileDescriptor folder(::openat(at_.number(), name.c_str(), kEnter)); folder) {
      rest_.pop_front();
      enter(std::move(folder));
      return bool(at_);
    }
    if (errno != ENOTDIR && errno != ELOOP) return false;
    const FileDescriptor link(
        ::openat(at_.number(), name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
    return link ? follow(link.number(), name) : false;
  }

  Result<bool> follow(int link, const std::string& name) {
    const auto target = target_of(link);
    if (!target) return refuse(ENOTDIR);
    if (++links_ > kMaxLinks) return refuse(ELOOP);
    DDSSEC_RETURN_IF_ERROR(check_link(link, name, *target));
    rest_.pop_front();
    const auto names = names_of(*target);
    rest_.insert(rest_.begin(), names.begin(), names.end());
    if (fs::path(*target).is_absolute()) enter_root();
    return bool(at_);
  }

  static Result<bool> refuse(int error) {
    errno = error;
    return false;
  }

  Status check_link(int link, const std::string& name, const std::string& target) const {
    struct stat own {
    }, folder{};
    const bool is_known = ::fstat(link, &own) == 0 && ::fstat(at_.number(), &folder) == 0;
    const bool is_open = is_writable_for_others(folder);
    if (is_known && is_guarded_ && (!is_open || is_of_trusted_owner(own))) return {};
    return fail(
        tool_code::link_untrusted,
        {.document = given_,
         .field = name,
         .expected = "a link that only root and this user can change, with the folders above it",
         .found = fmt::format("a link of user {} to {}, in a folder of user {}, mode {:04o}",
                              own.st_uid, target, folder.st_uid, folder.st_mode & 07777)});
  }

  fs::path given_;
  std::deque<std::string> rest_;
  FileDescriptor at_;
  bool is_guarded_ = false;
  int links_ = 0;
};

}  // namespace

Result<FileDescriptor> open_guarded(const fs::path& folder, int flags) {
  return GuardedWalk(folder).open(flags);
}

}  // namespace ddssec
