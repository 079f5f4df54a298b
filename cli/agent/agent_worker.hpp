// The process that works in a participant's folder. Code of the folder's owner can run in it: a key
// in a token needs a PKCS#11 module. So it is not a copy of the agent but the program started anew,
// without the agent's memory, output, terminal or secrets.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_participant.hpp"
#include "cli/agent/agent_process.hpp"

namespace ddssec::cli {

/// What main() is started with for this process, as the only word. Not a command of users.
inline constexpr auto kAgentWorker = "--agent-worker";

/// The variables of the worker. In a folder of another user: those of a short list that say where
/// libraries and their settings are, a usual PATH, and a HOME that does not exist, so that no
/// module is loaded that the owner configured. In a folder of the agent's own user: all but
/// `secret`.
std::vector<std::string> worker_variables(bool is_own, const std::vector<std::string>& secret);

/// Starts this program anew with these variables. `in` and `out` are its ends of two pipes, and
/// `lock` is a file that stays open (-1: none). Returns only if that fails: an exit code.
int become_worker(std::vector<std::string> variables, int in, int out, int lock);

/// The first line to a worker: what it is to do. `locked`: null with --dry-run. `now`: the time if
/// it is not the present.
std::string order_line(const AgentTask& task, const LockedFolder* locked,
                       std::optional<WallTime> now);

/// The worker's main program.
[[noreturn]] void run_agent_worker();

}  // namespace ddssec::cli
