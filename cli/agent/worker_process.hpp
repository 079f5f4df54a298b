// The process that works in one participant's folder, as the agent talks to it.
#pragma once

#include <optional>
#include <string_view>
#include <sys/types.h>

#include "base/clock.hpp"
#include "cli/agent/agent_process.hpp"
#include "cli/agent/slow_owners.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// A worker, which must answer within the time that the owner of its folder has. An owner can stop
/// the worker, so an owner whose worker does not answer is noted.
class WorkerProcess {
 public:
  /// `owner` is that of the folder; empty if it is not known. Borrows `slow` and `clock`.
  WorkerProcess(ChildProcess process, std::optional<uid_t> owner, SlowOwners& slow,
                const Clock& clock)
      : process_(std::move(process)), owner_(owner), slow_(slow), clock_(clock) {}

  /// Sends a line, with its line break. Errors: those of no_answer_error.
  Status write(std::string_view line);
  /// Receives a line. Errors: those of no_answer_error and json_from.
  Result<Json> read();
  /// Ends the process. Returns it if it cannot be ended.
  std::optional<ChildProcess> end();

 private:
  Deadline deadline() const;
  void note_slow();
  std::unexpected<Error> ended_error(ChildProcess::End end);

  ChildProcess process_;
  std::optional<uid_t> owner_;
  SlowOwners& slow_;
  const Clock& clock_;
};

}  // namespace ddssec::cli
