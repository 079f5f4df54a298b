// The agent, which looks after participants' folders one after the other.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/agent/agent_events.hpp"
#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_hook.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/agent/agent_overlaps.hpp"
#include "cli/agent/agent_participant.hpp"
#include "cli/agent/agent_process.hpp"
#include "cli/agent/silent_responders.hpp"
#include "cli/agent/slow_owners.hpp"
#include "cli/agent/worker_process.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// The programs that get certificates or documents from a CA elsewhere.
struct AgentHooks {
  std::optional<Hook> certificates = {};  ///< empty: a CA of this machine (--ca)
  std::optional<Hook> documents = {};     ///< permissions and lists
};

/// Renews what is due in some folders. For each of them a process with the rights of the folder's
/// owner reads and writes the files (agent_participant.hpp), and another one with the agent's own
/// rights asks the CA. The agent itself reads no file of a folder, and no key.
class Agent {
 public:
  Agent(const Arguments& arguments, AgentHooks hooks, const Context& context);

  /// Looks at each folder once. The errors of those that failed are in the report.
  Answer<AgentRun> run_once();
  /// Goes on until SIGTERM or SIGINT. After SIGHUP it looks at all folders now.
  Answer<AgentRun> run();

 private:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  struct Folder {
    AgentTask task;
    std::optional<FolderLock> lock = {};
    Moment next{0};
    Moment next_documents{0};
    unsigned failures = 0;
    /// The lifetime of its certificate, which decides how often the CA is asked. For a folder of
    /// another user it is therefore known only after the CA has accepted the certificate.
    std::chrono::seconds lifetime{std::chrono::days(1)};
    std::string last_reported_serial = {};
    std::optional<ChildProcess> unended = {};  ///< its last worker, if that could not be ended
    bool is_paused = false;
    bool has_problem = false;  ///< true if the last event had a "problem"
  };

  void visit(Folder& folder);
  void note_outcome(Folder& folder, Result<Json> event);
  void complete_lists();
  void end_overlaps();
  /// Returns false if the overlap could not be ended.
  bool end_overlap_and_report(const OverlapToEnd& overlap);
  Result<Json> run_worker(Folder& folder);
  Result<WorkerProcess> start_worker(const Folder& folder);
  /// Returns the CA's renewal list as text, and notes its problem.
  std::string renewal_list_text();
  /// Reports that problem, unless it is the one that was reported last.
  void report_list_problem();
  void note_documents(Folder& folder, const Json& outcome);
  Result<Bytes> ask_document(const Folder& folder, const DocumentRequest& request);
  Result<Json> serve_worker(Folder& folder, WorkerProcess& worker);
  Result<Json> finish_worker(const Folder& folder, WorkerProcess& worker, std::string_view answer);
  /// Returns the event or the error in a worker's last line.
  Result<Json> outcome_from(const Folder& folder, const Json& line);
  Result<RenewalAnswer> ask_ca(const Folder& folder, const RenewalRequest& request);
  Result<Json> answer_documents(Folder& folder, WorkerProcess& worker);
  Result<RenewalAnswer> ask_own_ca(const Folder& folder, const RenewalRequest& request);
  Status check_request(const RenewalRequest& request);
  Status check_ca_opens();
  Result<Json> run_in_child_process(const std::function<Result<Json>()>& work);
  /// Runs a check that uses the CA or reads files of its own in such a process.
  Status check_in_child_process(const std::function<Status()>& check);
  /// Keeps the error of the member "problem" for the report, and makes the member one of an event.
  /// Returns false if there is no such member.
  bool note_problem(Json& event);
  void note_success(Folder& folder, Json event);
  void note_failure(Folder& folder, const Error& error);
  void schedule_all_now();
  void schedule_others(const Folder& renewed);
  Json start_members() const;

  const Arguments& arguments_;
  AgentHooks hooks_;
  const Context& context_;
  HeldSignals signals_;
  AgentEvents events_;
  std::vector<Folder> folders_;
  /// The error if the CA's key refused its PIN or passphrase.
  std::optional<Error> ca_refusal_ = {};
  std::set<uid_t> owners_with_wrong_pin_ = {};  ///< owners of a folder whose token refused the PIN
  SlowOwners slow_owners_;
  SilentResponders silent_responders_ = {};
  Moment next_end_{0};                      ///< when the agent looks for overlaps to end
  std::optional<Error> list_problem_ = {};  ///< of the CA's renewal list, when it was last read
  std::optional<Code> reported_list_problem_ = {};
  unsigned failed_ends_ = 0;  ///< looks in a row in which an overlap could not be ended
  std::vector<Error> errors_ = {};
  std::vector<WrittenFile> written_ = {};
};

}  // namespace ddssec::cli
