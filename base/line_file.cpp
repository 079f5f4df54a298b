#include "base/line_file.hpp"

#include <cerrno>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

#include "base/errno_text.hpp"

namespace ddssec {
namespace {

bool is_suitable(int file) {
  struct stat found {};
  return fstat(file, &found) == 0 &&
         (S_ISREG(found.st_mode) || S_ISFIFO(found.st_mode) || S_ISCHR(found.st_mode));
}

int open_suitable(const char* path) {
  // Without O_NONBLOCK, a FIFO without a reader would block the process at start.
  const int file =
      open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0640);
  if (file < 0 || is_suitable(file)) return file;
  close(file);
  errno = 0;
  return -1;
}

std::string reason() {
  if (errno == 0) return "something else";
  return errno == ENXIO ? "a FIFO without a reader" : errno_text(errno);
}

// Suppresses SIGPIPE, which a FIFO without a reader raises in the writing thread.
class SigpipeBlock {
 public:
  SigpipeBlock() {
    sigemptyset(&sigpipe_);
    sigaddset(&sigpipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    // A SIGPIPE that is already pending belongs to the host, and is blocked.
    if (sigismember(&pending, SIGPIPE) == 1) return;
    is_ours_ = pthread_sigmask(SIG_BLOCK, &sigpipe_, &before_) == 0;
  }
  ~SigpipeBlock() {
    if (!is_ours_) return;
    const timespec at_once{};
    while (sigtimedwait(&sigpipe_, nullptr, &at_once) == SIGPIPE) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  SigpipeBlock(const SigpipeBlock&) = delete;
  SigpipeBlock& operator=(const SigpipeBlock&) = delete;

 private:
  sigset_t sigpipe_;
  sigset_t before_;
  bool is_ours_ = false;
};

}  // namespace

LineFile::LineFile(const char* path) : file_(open_suitable(path)) {
  if (file_ < 0) why_not_ = reason();
}

LineFile::~LineFile() {
  if (is_open()) close(file_);
}

bool LineFile::append(std::string_view line) {
  const bool was_torn = is_torn_.exchange(false);
  const auto text = std::string(was_torn ? "\n" : "").append(line) + "\n";
  const SigpipeBlock guard;
  const auto written = write(file_, text.data(), text.size());
  const bool is_whole = written == static_cast<ssize_t>(text.size());
  if (written < 0 ? was_torn : !is_whole) is_torn_ = true;
  return is_whole;
}

}  // namespace ddssec
