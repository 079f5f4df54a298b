// The process that works in a participant's folder. A key in a token needs a PKCS#11 module, so
// code of the folder's owner can run in this process. It is therefore not a copy of the agent but
// a new process of the program, without the agent's memory, output, terminal or secrets.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_participant.hpp"
#include "cli/agent/agent_process.hpp"

namespace ddssec::cli {

/// The only argument with which main() is started for this process. It is not a command for users.
inline constexpr auto kAgentWorker = "--agent-worker";

/// Returns the environment variables of the worker. Those of --hook-env and --passphrase-env are
/// not among them. In a folder of the agent's own user it has all others. In a folder of another
/// user it has a usual PATH and those of a short list that say where libraries and their settings
/// are. Its HOME does not exist then, so that no module is loaded that the owner configured.
std::vector<std::string> worker_variables(bool is_own, const Arguments& arguments);

/// Starts a new process of this program with these variables. `in` and `out` are its ends of two
/// pipes, and `lock` is a file that stays open (-1: none). Returns only if that fails, with an exit
/// code.
int become_worker(std::vector<std::string> variables, int in, int out, int lock);

/// Returns the first line to a worker, which tells it what to do. `locked` is nullptr with
/// --dry-run. `now` is a time to use instead of the present.
std::string order_line(const AgentTask& task, const LockedFolder* locked,
                       std::optional<WallTime> now);

/// Does the worker's work, and ends the process.
[[noreturn]] void run_agent_worker();

}  // namespace ddssec::cli
