// What a hook writes to standard error.
#pragma once

#include <string>

#include "base/file_descriptor.hpp"
#include "cli/agent/agent_process.hpp"
#include "cli/agent/event_output.hpp"

namespace ddssec::cli {

/// Passes the messages of one hook on to the agent's standard error, while the agent waits for the
/// hook. Each line begins with "hook: " and has no control characters. A hook may print what a CA
/// elsewhere answered, and the journal has the agent's events beside it: without the beginning, a
/// message could look like an event.
class HookMessages {
 public:
  /// Opens the pipe. If that fails, the hook cannot be started.
  explicit HookMessages(HeldSignals& signals);
  /// Passes on the rest.
  ~HookMessages();
  HookMessages(const HookMessages&) = delete;
  HookMessages& operator=(const HookMessages&) = delete;

  /// Returns the hook's end of the pipe, -1 if there is none.
  int hook_end() const { return hook_end_.number(); }
  /// Closes the hook's end in this process. Call this when the hook has been started.
  void close_hook_end() { hook_end_ = FileDescriptor(); }

 private:
  bool pass_on();
  void put_line(std::string_view line);

  HeldSignals& signals_;
  FileDescriptor own_end_, hook_end_;
  std::string begun_ = {};  ///< a line that has not ended yet
  EventOutput output_;
};

}  // namespace ddssec::cli
