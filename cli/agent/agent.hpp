// The agent, which looks after participants' folders one after the other.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/agent/agent_events.hpp"
#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_overlaps.hpp"
#include "cli/agent/agent_participant.hpp"
#include "cli/agent/agent_process.hpp"
#include "cli/agent/ca_requests.hpp"
#include "cli/agent/renewal_limit.hpp"
#include "cli/agent/repeated_problem.hpp"
#include "cli/agent/silent_responders.hpp"
#include "cli/agent/slow_owners.hpp"
#include "cli/agent/worker_process.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

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
    Moment next{0};          ///< the next visit
    Moment next_attempt{0};  ///< after a failure: before that time nothing is renewed
    Moment next_documents{0};
    unsigned failures = 0;
    /// The lifetime of its certificate, which decides how often the CA is asked. For a folder of
    /// another user it is therefore that of the last certificate that the CA answered.
    std::chrono::seconds lifetime{std::chrono::days(1)};
    std::string last_reported_serial = {};
    std::optional<ChildProcess> unended = {};  ///< its last worker, if that could not be ended
    bool has_problem = false;                  ///< true if the last event had a "problem"
    RenewalLimit limit = {};
    /// Why nothing is renewed before SIGHUP; empty if it is.
    std::optional<Error> refusal = {};
    RepeatedProblem reported_refusal = {};
    RepeatedProblem lasting_problem = {};  ///< of the documents that the second hook brings
    RepeatedProblem list_warning = {};
  };

  void visit(Folder& folder);
  void note_outcome(Folder& folder, Result<Json> event);
  void note_waiting_visit(Folder& folder, Result<Json> event);
  void schedule_waiting(Folder& folder);
  void complete_lists();
  void end_overlaps();
  /// Returns false if the overlap could not be ended and is to be tried again.
  bool end_overlap_and_report(const OverlapToEnd& overlap);
  Result<Json> run_worker(Folder& folder);
  Result<WorkerProcess> start_worker(const Folder& folder);
  /// Returns the CA's renewal list as text, and notes its problem.
  std::string renewal_list_text();
  /// Reports that problem, unless it is the one that was reported last.
  void report_list_problem();
  void note_documents(Folder& folder, const Json& outcome);
  /// Reports a problem that stays once a day, and removes it from the members otherwise.
  void note_lasting_problem(Folder& folder, Json& members);
  Result<Json> serve_worker(Folder& folder, WorkerProcess& worker);
  Result<RenewalAnswer> ask_ca(const Folder& folder, const RenewalRequest& request);
  void note_answer(Folder& folder, const RenewalAnswer& answer);
  Result<Json> finish_worker(const Folder& folder, WorkerProcess& worker, std::string_view answer);
  /// Returns the outcome. `line` is what the worker sent first after its requests.
  Result<Json> outcome_after(const Folder& folder, WorkerProcess& worker, const Json& line);
  /// Returns the event or the error in a worker's last line.
  Result<Json> outcome_from(const Folder& folder, const Json& line);
  Result<Json> answer_documents(Folder& folder, WorkerProcess& worker);
  /// Keeps the error of the member "problem" for the report, and makes the member one of an event.
  /// Returns false if there is no such member, or if it is only a warning.
  bool note_problem(Json& event);
  void leave_out_repeated_warning(Folder& folder, Json& event);
  void note_success(Folder& folder, Json event);
  void note_failure(Folder& folder, const Error& error);
  void report_failure(const Folder& folder, const Error& error, Json again_in);
  void schedule_all_now();
  void schedule_others(const Folder& renewed);
  Json start_members() const;

  const Arguments& arguments_;
  const Context& context_;
  HeldSignals signals_;
  CaRequests ca_;
  AgentEvents events_;
  std::vector<Folder> folders_;
  std::set<uid_t> owners_with_wrong_pin_ = {};  ///< owners of a folder whose token refused the PIN
  SlowOwners slow_owners_;
  SilentResponders silent_responders_ = {};
  Moment next_end_{0};                      ///< when the agent looks for overlaps to end
  std::optional<Error> list_problem_ = {};  ///< of the CA's renewal list, when it was last read
  std::optional<Code> reported_list_problem_ = {};
  unsigned failed_ends_ = 0;  ///< looks in a row in which an overlap could not be ended
  /// Roles of CAs whose overlap was not ended because a key refused its PIN. Nothing is tried
  /// before SIGHUP.
  std::set<std::string> refused_ends_ = {};
  std::vector<Error> errors_ = {};
  std::vector<WrittenFile> written_ = {};
};

}  // namespace ddssec::cli
