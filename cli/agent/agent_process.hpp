// The agent's child processes, with which it exchanges texts of bounded length in bounded time, and
// the signals that reach the agent meanwhile.
#pragma once

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>

#include "base/result.hpp"

namespace ddssec::cli {

using Deadline = std::chrono::steady_clock::time_point;

/// Blocks SIGTERM, SIGINT and SIGHUP as long as it lives, and receives them while it waits.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  /// The reason why a wait ended.
  enum class Woken : std::uint8_t { ready, stop, time };
  /// Waits until the file has one of the events (of poll; -1: no file), until the deadline, or
  /// until SIGTERM or SIGINT, which may have arrived before. With `for_reload`, SIGHUP also ends
  /// the wait, like the deadline.
  Woken wait(int file, short events, Deadline deadline, bool for_reload = false);

  /// Calls `on_readable` in each wait while the file has something to read, until it returns false.
  /// -1: no file.
  void watch(int file, std::function<bool()> on_readable);

  bool is_stopped() const { return is_stopped_; }
  /// True once after each SIGHUP.
  bool take_reload();
  /// Returns the signal mask from before, for a child.
  const sigset_t& former() const { return former_; }

 private:
  void read_signals();
  sigset_t former_{};
  int file_ = -1;
  int watched_ = -1;
  std::function<bool()> on_readable_ = {};
  bool is_stopped_ = false;
  bool is_reload_ = false;
};

/// A child process. It is killed with its process group if it still runs when this is destroyed.
/// SIGKILL does not end a process while it waits for a file system that does not answer. So no
/// function waits for the end without a limit.
class ChildProcess {
 public:
  /// The work of a child; its process ends with the exit code. `in` and `out` are the child's ends
  /// of two pipes.
  using Body = std::function<int(int in, int out)>;
  /// Starts a child in a session of its own, which has no terminal and leaves no core file, with
  /// /dev/null as standard input. Of the open files it inherits only the pipes, standard output,
  /// standard error and `kept` (-1: none). Error: internal.
  static Result<ChildProcess> start(HeldSignals& signals, const Body& body, int kept = -1);

  /// The outcome of an exchange with a child.
  enum class End : std::uint8_t { done, closed, too_long, too_slow, stopped };
  /// Writes to the child's `in`. Returns `closed` if the child does not read any more.
  End write(std::string_view text, Deadline deadline);
  /// Closes the child's `in`.
  void end_input();
  /// Reads up to the next line end, which is not part of `line`.
  End read_line(std::string& line, std::size_t max_octets, Deadline deadline);
  /// Reads all until the child closes its `out`.
  End read_all(std::string& text, std::size_t max_octets, Deadline deadline);
  /// Waits until the process has ended of its own accord, then kills what it left running in its
  /// group.
  End wait(Deadline deadline);
  /// Ends the process with SIGTERM and, after two seconds, its whole group with SIGKILL. Returns
  /// false if the process has not ended two seconds after that.
  bool stop();
  /// Returns true if the process has ended.
  bool reap();
  pid_t number() const { return pid_; }
  /// Returns "exit code 3" or "signal 9". Empty for exit code 0, or if the process has not ended.
  std::string failure() const;

  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

 private:
  ChildProcess(HeldSignals& signals, pid_t pid, int in, int out)
      : signals_(signals), pid_(pid), in_(in), out_(out) {}
  End fill(std::size_t max_octets, Deadline deadline);
  void signal_group(int signal) const;
  void kill_group();
  HeldSignals& signals_;
  pid_t pid_;
  int in_, out_;
  std::string buffer_ = {};  ///< read from the child, but not yet returned
  bool is_killed_ = false;
  std::optional<int> status_ = {};
};

/// Returns the error for an exchange that did not end with `done`. Errors: interrupted (stopped),
/// internal.
std::unexpected<Error> no_answer_error(ChildProcess::End end);

}  // namespace ddssec::cli
