#include "cli/agent/agent_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/errno_text.hpp"

namespace ddssec::cli {
namespace {

using Woken = HeldSignals::Woken;
using End = ChildProcess::End;
using std::chrono::steady_clock;

constexpr std::chrono::seconds kTimeToEnd{2};
constexpr std::size_t kMaxUnended = 64;

// The processes that had not ended when their ChildProcess was destroyed.
std::vector<pid_t>& unended() {
  static std::vector<pid_t> all;
  return all;
}

void reap_unended() {
  std::erase_if(unended(), [](pid_t pid) { return ::waitpid(pid, nullptr, WNOHANG) != 0; });
}

int milliseconds_until(Deadline deadline) {
  // The wait is cut because poll() does not count the time while a machine sleeps.
  constexpr std::chrono::milliseconds kMax{60'000};
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
  return static_cast<int>(std::clamp(left, std::chrono::milliseconds(0), kMax).count());
}

std::unexpected<Error> no_process_error(int error) {
  return fail(Code::internal, {.field = "a process", .note = errno_text(error)});
}

// The header of glibc 2.36 declares pidfd_open without C linkage, so C++ cannot link to it.
int open_process(pid_t pid) { return static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)); }

// Waits at most kTimeToEnd.
void wait_for_end(pid_t pid) {
  const int file = open_process(pid);
  if (file < 0) return;
  pollfd one{file, POLLIN, 0};
  ::poll(&one, 1, static_cast<int>(std::chrono::milliseconds(kTimeToEnd).count()));
  ::close(file);
}

void close_between(int first, int last) {
  if (first <= last) ::close_range(static_cast<unsigned>(first), static_cast<unsigned>(last), 0);
}

void close_all_but(std::array<int, 3> kept) {
  std::ranges::sort(kept);
  int first = STDERR_FILENO + 1;
  for (const int one : kept) {
    if (one < first) continue;
    close_between(first, one - 1);
    first = one + 1;
  }
  ::close_range(static_cast<unsigned>(first), ~0U, 0);
}

[[noreturn]] void run_child(const HeldSignals& signals, const ChildProcess::Body& body, int in,
                            int out, int kept) {
  // A core file could have a key or a passphrase.
  constexpr rlimit kNoCore = {.rlim_cur = 0, .rlim_max = 0};
  ::setrlimit(RLIMIT_CORE, &kNoCore);
  ::setsid();  // with the agent's terminal, code in the child could type commands there
  // The child gets SIGTERM when the agent ends. If the agent has ended already, a worker reads the
  // end of its pipe instead.
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  ::signal(SIGPIPE, SIG_IGN);
  ::sigprocmask(SIG_SETMASK, &signals.former(), nullptr);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing >= 0) ::dup2(nothing, STDIN_FILENO);
  close_all_but({in, out, kept});
  ::_exit(body(in, out));
}

}  // namespace

HeldSignals::HeldSignals() {
  sigset_t held;
  ::sigemptyset(&held);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&held, signal);
  ::sigprocmask(SIG_BLOCK, &held, &former_);
  file_ = ::signalfd(-1, &held, SFD_CLOEXEC | SFD_NONBLOCK);
}

HeldSignals::~HeldSignals() {
  read_signals();
  ::close(file_);
  ::sigprocmask(SIG_SETMASK, &former_, nullptr);
}

void HeldSignals::read_signals() {
  signalfd_siginfo one{};
  while (::read(file_, &one, sizeof one) == static_cast<ssize_t>(sizeof one))
    (one.ssi_signo == static_cast<unsigned>(SIGHUP) ? is_reload_ : is_stopped_) = true;
}

void HeldSignals::watch(int file, std::function<bool()> on_readable) {
  watched_ = file;
  on_readable_ = std::move(on_readable);
}

bool HeldSignals::take_reload() { return std::exchange(is_reload_, false); }

Woken HeldSignals::wait(int file, short events, Deadline deadline, bool for_reload) {
  while (true) {
    read_signals();
    if (is_stopped_) return Woken::stop;
    if (for_reload && is_reload_) return Woken::time;
    std::array<pollfd, 3> files{pollfd{file_, POLLIN, 0}, pollfd{file, events, 0},
                                pollfd{watched_, POLLIN, 0}};
    if (::poll(files.data(), files.size(), milliseconds_until(deadline)) > 0) {
      if (files[2].revents != 0 && !on_readable_()) watch(-1, {});
      if (files[1].revents != 0) return Woken::ready;
      if (files[2].revents != 0 && steady_clock::now() >= deadline) return Woken::time;
    } else if (steady_clock::now() >= deadline) {
      return Woken::time;
    }
  }
}

Result<ChildProcess> ChildProcess::start(HeldSignals& signals, const Body& body, int kept) {
  reap_unended();
  if (unended().size() >= kMaxUnended)
    return fail(Code::internal,
                {.field = "a process",
                 .note = fmt::format("{} former ones cannot be ended", unended().size())});
  std::array<int, 2> down{}, up{};
  if (::pipe2(down.data(), O_CLOEXEC) != 0) return no_process_error(errno);
  if (::pipe2(up.data(), O_CLOEXEC) != 0) {
    const int error = errno;
    for (const int file : down) ::close(file);
    return no_process_error(error);
  }
  const pid_t pid = ::fork();
  if (pid == 0) run_child(signals, body, down[0], up[1], kept);
  const int error = errno;
  ::close(down[0]);
  ::close(up[1]);
  ChildProcess out(signals, pid, down[1], up[0]);
  if (pid < 0) return no_process_error(error);
  for (const int file : {out.in_, out.out_}) ::fcntl(file, F_SETFL, O_NONBLOCK);
  return out;
}

End ChildProcess::write(std::string_view text, Deadline deadline) {
  while (!text.empty()) {
    const auto woken = signals_.wait(in_, POLLOUT, deadline);
    if (woken == Woken::stop) return End::stopped;
    if (woken == Woken::time) return End::too_slow;
    const auto written = ::write(in_, text.data(), text.size());
    if (written > 0)
      text.remove_prefix(static_cast<std::size_t>(written));
    else if (errno != EAGAIN && errno != EINTR)
      return End::closed;
  }
  return End::done;
}

void ChildProcess::end_input() {
  if (in_ >= 0) ::close(std::exchange(in_, -1));
}

// Returns `done` if there are more octets than before in the buffer.
End ChildProcess::fill(std::size_t max_octets, Deadline deadline) {
  std::array<char, 4096> part{};
  while (true) {
    const auto woken = signals_.wait(out_, POLLIN, deadline);
    if (woken == Woken::stop) return End::stopped;
    if (woken == Woken::time) return End::too_slow;
    const auto size = ::read(out_, part.data(), part.size());
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size <= 0) return End::closed;
    buffer_.append(part.data(), static_cast<std::size_t>(size));
    return buffer_.size() > max_octets ? End::too_long : End::done;
  }
}

End ChildProcess::read_line(std::string& line, std::size_t max_octets, Deadline deadline) {
  while (true) {
    if (const auto end = buffer_.find('\n'); end != buffer_.npos) {
      line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return End::done;
    }
    if (const auto end = fill(max_octets, deadline); end != End::done) return end;
  }
}

End ChildProcess::read_all(std::string& text, std::size_t max_octets, Deadline deadline) {
  while (true) {
    const auto end = fill(max_octets, deadline);
    if (end == End::done) continue;
    text = std::move(buffer_);
    return end == End::closed ? End::done : end;
  }
}

End ChildProcess::wait(Deadline deadline) {
  const int file = open_process(pid_);
  if (file < 0) return End::too_slow;
  const auto woken = signals_.wait(file, POLLIN, deadline);
  ::close(file);
  if (woken != Woken::ready) return woken == Woken::stop ? End::stopped : End::too_slow;
  kill_group();
  return reap() ? End::done : End::too_slow;
}

// Also signals the process itself, because it may not have made its group yet.
void ChildProcess::signal_group(int signal) const {
  ::kill(-pid_, signal);
  ::kill(pid_, signal);
}

// Kills the process and what it left running. No other group can have its number until the process
// is reaped.
void ChildProcess::kill_group() {
  signal_group(SIGKILL);
  is_killed_ = true;
  wait_for_end(pid_);
}

bool ChildProcess::reap() {
  if (pid_ <= 0 || status_) return true;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  return status_.has_value();
}

// A stop signal that arrived earlier must not shorten these waits, so this function ignores
// signals_.
bool ChildProcess::stop() {
  if (pid_ <= 0 || status_) return true;
  if (!is_killed_) {
    signal_group(SIGTERM);
    wait_for_end(pid_);
    kill_group();
  }
  return reap();
}

std::string ChildProcess::failure() const {
  if (!status_ || *status_ == 0) return {};
  return WIFSIGNALED(*status_) ? fmt::format("signal {}", WTERMSIG(*status_))
                               : fmt::format("exit code {}", WEXITSTATUS(*status_));
}

ChildProcess::~ChildProcess() {
  if (!stop()) unended().push_back(pid_);
  end_input();
  if (out_ >= 0) ::close(out_);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : signals_(other.signals_),
      pid_(std::exchange(other.pid_, -1)),
      in_(std::exchange(other.in_, -1)),
      out_(std::exchange(other.out_, -1)),
      buffer_(std::move(other.buffer_)),
      is_killed_(other.is_killed_),
      status_(other.status_) {}

std::unexpected<Error> no_answer_error(ChildProcess::End end) {
  if (end == ChildProcess::End::stopped) return fail(Code::interrupted);
  return fail(Code::internal,
              {.field = "a process of the agent",
               .note = end == ChildProcess::End::too_slow ? "it took too long" : "it has ended"});
}

}  // namespace ddssec::cli
