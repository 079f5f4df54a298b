#include "cli/frame/file_lock.hpp"

#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/frame/file_transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Returns the number of the process that holds a lock on the file, from a line of /proc/locks such
// as "1: FLOCK  ADVISORY  WRITE 4711 08:01:1234 0 EOF". Empty if no line names the file.
std::string holder_of(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return {};
  const auto wanted = fmt::format(" {:02x}:{:02x}:{} ", ::major(status.st_dev),
                                  ::minor(status.st_dev), status.st_ino);
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    const auto at = line.find(wanted);
    if (at == line.npos || !line.contains(": FLOCK ")) continue;
    return line.substr(line.rfind(' ', at - 1) + 1, at - line.rfind(' ', at - 1) - 1);
  }
  return {};
}

// False for 0 (a process of another container) and for -1, which name no process.
bool is_process(const std::string& pid) { return !pid.empty() && pid != "0" && pid[0] != '-'; }

std::unexpected<Error> still_locked_error(int file, const fs::path& path,
                                          std::chrono::seconds timeout) {
  const auto pid = holder_of(file);
  struct stat process {};
  std::string holder = "another process";
  if (is_process(pid)) {
    holder = "process " + pid;
    if (::stat(("/proc/" + pid).c_str(), &process) == 0)
      holder += fmt::format(" of user {}", process.st_uid);
  }
  return fail(Code::file_unwritable,
              {.document = path,
               .note = fmt::format("{} has locked it for more than {} s", holder, timeout.count()),
               .hint = "wait until that process has ended, or end it; then run the command again"});
}

// Opens the file for writing if possible, because a network file system needs that for a lock.
int open_for_lock(const fs::path& path) {
  constexpr int kFlags = O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  const int file = ::open(path.c_str(), O_RDWR | kFlags);
  return file >= 0 ? file : ::open(path.c_str(), O_RDONLY | kFlags);
}

bool is_still_at(const fs::path& path, int file) {
  struct stat open {};
  struct stat there {};
  return ::fstat(file, &open) == 0 && ::stat(path.c_str(), &there) == 0 &&
         open.st_ino == there.st_ino && open.st_dev == there.st_dev;
}

}  // namespace

Status lock_file(int file, const fs::path& path, std::chrono::seconds timeout) {
  constexpr std::chrono::milliseconds kPause{20};
  const auto end = Clock::now() + timeout;
  while (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return unwritable_error(path, errno);
    DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
    if (Clock::now() >= end) return still_locked_error(file, path, timeout);
    std::this_thread::sleep_for(kPause);
  }
  return {};
}

class FileLock::HeldFile {
 public:
  explicit HeldFile(int file) : file_(file) {}
  ~HeldFile() { ::close(file_); }
  HeldFile(const HeldFile&) = delete;
  HeldFile& operator=(const HeldFile&) = delete;
  int file() const { return file_; }

 private:
  int file_;
};

namespace {

bool is_same_file(int a, int b) {
  struct stat first {};
  struct stat second {};
  return ::fstat(a, &first) == 0 && ::fstat(b, &second) == 0 && first.st_ino == second.st_ino &&
         first.st_dev == second.st_dev;
}

}  // namespace

// The locks that this process holds. If a process opened a file twice, its own locks would exclude
// each other.
std::vector<std::weak_ptr<FileLock::HeldFile>>& FileLock::all() {
  static std::vector<std::weak_ptr<HeldFile>> out;
  return out;
}

Result<FileLock> FileLock::of(const fs::path& path) {
  while (true) {
    const int file = open_for_lock(path);
    if (file < 0) return unwritable_error(path, errno);
    const auto opened = std::make_shared<HeldFile>(file);
    for (const auto& other : all())
      if (auto held = other.lock(); held && is_same_file(held->file(), file)) return FileLock(held);
    DDSSEC_RETURN_IF_ERROR(lock_file(file, path, kLockTimeout));
    if (is_still_at(path, file)) {
      all().push_back(opened);
      return FileLock(opened);
    }
    DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  }
}

}  // namespace ddssec::cli
