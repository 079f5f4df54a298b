#include "cli/folder_path.hpp"

#include <array>
#include <cerrno>
#include <climits>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "base/tool_code.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // as the kernel follows

bool is_trusted(uid_t user) { return user == 0 || user == ::geteuid(); }

// Members of a user's own group may be trusted by that user, but not by root.
bool can_others_replace_in(const struct stat& folder) {
  const mode_t others = ::geteuid() == 0 ? 022 : 002;
  return (folder.st_mode & others) != 0 && (folder.st_mode & S_ISVTX) == 0;
}

bool is_trusted_link(int folder, const struct stat& link) {
  struct stat status {};
  return ::fstat(folder, &status) == 0 && is_trusted(link.st_uid) && is_trusted(status.st_uid) &&
         !can_others_replace_in(status);
}

Descriptor open_in(int folder, const std::string& name, int flags) {
  return Descriptor(::openat(folder, name.c_str(), flags | O_NOFOLLOW | O_CLOEXEC));
}

/// Follows a path one name after the other, so that nothing is exchanged in between.
class Walk {
 public:
  explicit Walk(const fs::path& path) { go_to(path); }

  OpenedFolder to_the_end(int flags) {
    while (!names_.empty() && out_.error == 0 && out_.foreign_link.empty()) step();
    if (out_.error != 0 || !out_.foreign_link.empty()) return std::move(out_);
    // The descriptors so far have O_PATH alone, which needs no right to search the folder.
    out_.folder =
        flags == O_PATH ? std::move(at_) : open_in(at_.number(), ".", flags | O_DIRECTORY);
    if (!out_.folder) out_.error = errno;
    return std::move(out_);
  }

 private:
  void go_to(const fs::path& path) {
    if (path.is_absolute() || !at_) at_ = open_in(AT_FDCWD, path.is_absolute() ? "/" : ".", O_PATH);
    if (!at_) out_.error = errno;
    if (path.is_absolute()) seen_ = "/";
    const auto relative = path.relative_path();
    std::vector<std::string> names(relative.begin(), relative.end());
    names_.insert(names_.end(), names.rbegin(), names.rend());
    std::erase(names_, "");
  }

  void step() {
    const auto name = std::move(names_.back());
    names_.pop_back();
    auto next = open_in(at_.number(), name, O_PATH);
    struct stat status {};
    if (!next || ::fstat(next.number(), &status) != 0) {
      out_.error = errno;
    } else if (S_ISLNK(status.st_mode)) {
      follow(next.number(), name, status);
    } else if (!S_ISDIR(status.st_mode)) {
      out_.error = ENOTDIR;
    } else {
      at_ = std::move(next);
      seen_ /= name;
    }
  }

  void follow(int link, const std::string& name, const struct stat& status) {
    if (names_.empty() || ++links_ > kMostLinks) {
      out_.error = ELOOP;
      return;
    }
    if (!is_trusted_link(at_.number(), status)) {
      out_.foreign_link = seen_ / name;
      return;
    }
    std::array<char, PATH_MAX> target{};
    const auto size = ::readlinkat(link, "", target.data(), target.size());
    if (size <= 0 || size == static_cast<ssize_t>(target.size())) {
      out_.error = size < 0 ? errno : ENAMETOOLONG;
      return;
    }
    go_to(std::string(target.data(), static_cast<std::size_t>(size)));
  }

  Descriptor at_;
  fs::path seen_;                   ///< what the path has led to
  std::vector<std::string> names_;  ///< still to go, in reverse order
  int links_ = 0;
  OpenedFolder out_;
};

}  // namespace

std::unexpected<Error> foreign_link(const fs::path& folder, const fs::path& link) {
  return fail(tool_code::folder_untrusted,
              {.document = folder,
               .expected = "a path without links that other users can make or replace",
               .found = "the link " + link.string(),
               .hint = "name the folder itself, or make the link as root in a folder of root"});
}

OpenedFolder open_folder_by_path(const fs::path& path, int flags) {
  return Walk(path).to_the_end(flags);
}

}  // namespace ddssec::cli
