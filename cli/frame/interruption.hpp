// Signals that end a command. A command ends before its next file, so that no draft is left behind.
#pragma once

#include "base/result.hpp"

namespace ddssec::cli {

/// From now on SIGINT, SIGTERM and SIGHUP end the command at the next file with `interrupted`. If
/// no file follows within 200 ms, the signal itself ends it, unless an InterruptionGuard is alive.
void note_interruptions();
/// Success unless a signal arrived. Error: interrupted.
Status check_not_interrupted();

/// Lives as long as there are drafts of files or folders that are neither in place nor removed.
class InterruptionGuard {
 public:
  InterruptionGuard();
  ~InterruptionGuard();
  InterruptionGuard(InterruptionGuard&& other) noexcept;
  InterruptionGuard& operator=(InterruptionGuard&&) = delete;

 private:
  bool is_counted_ = true;
};

}  // namespace ddssec::cli
