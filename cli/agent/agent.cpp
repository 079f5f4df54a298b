#include "cli/agent/agent.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <tuple>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/agent/agent_ca.hpp"
#include "cli/agent/agent_schedule.hpp"
#include "cli/agent/agent_worker.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/new_file.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;

// The longest pause between two visits. If a folder was changed by hand, or a clock was set, the
// agent notices it after this time at the latest.
constexpr seconds kMaxRest{600};
constexpr seconds kMinRestOfOthers{60};
// The longest time between two looks for overlaps, which other commands may begin at any time.
constexpr seconds kMaxLook{60};
constexpr seconds kRetryEnd{3600};

// The files that the agent has open: for each folder those of its lock and the pipes of a process
// that cannot be ended; pipes, signals and others.
constexpr rlim_t kFilesOfFolder = 4;
constexpr rlim_t kOtherFiles = 64;

// A process that does not keep to the protocol is treated like one that has ended.
std::unexpected<Error> protocol_error() { return no_answer_error(ChildProcess::End::closed); }

// Otherwise one more process would stay at each visit.
std::unexpected<Error> unended_error(const std::filesystem::path& folder,
                                     const ChildProcess& worker) {
  return fail(tool_code::process_unended,
              {.document = folder, .found = fmt::format("process {}", worker.number())});
}

}  // namespace

Agent::Agent(const Arguments& arguments, AgentHooks hooks, const Context& context)
    : arguments_(arguments),
      context_(context),
      ca_(arguments, std::move(hooks), context, signals_),
      events_(arguments.text("--format") == "json" ? AgentEvents::To::report
                                                   : AgentEvents::To::standard_output,
              context.clock),
      slow_owners_(::geteuid()) {
  ::signal(SIGPIPE, SIG_IGN);
  for (const auto& folder : arguments.all("FOLDERS"))
    folders_.push_back({.task = {.folder = folder,
                                 .is_rekeying = arguments.has("--rekey"),
                                 .takes_permissions = arguments.has("--permissions"),
                                 .is_dry_run = writes_nothing()}});
  allow_open_files(kFilesOfFolder * folders_.size() + kOtherFiles);
}

Json Agent::start_members() const {
  Json out = {{"folders", folders_.size()},
              {"by", ca_.has_certificate_hook() ? "hook" : "ca"},
              {"pid", ::getpid()}};
  if (!ca_.has_certificate_hook()) return out;
  const auto lists =
      lists_file({.trust = arguments_.text("--trust"), .lists = arguments_.text("--crl")});
  out["crl"] = lists.empty() ? Json() : Json(lists.string());
  return out;
}

Answer<AgentRun> Agent::run_once() {
  if (const auto proven = ca_.check_ca_opens(); !proven) return {{}, report_of(proven.error())};
  end_overlaps();
  for (auto& folder : folders_)
    if (!signals_.is_stopped()) visit(folder);
  complete_lists();
  if (signals_.is_stopped()) errors_.emplace_back(Code::interrupted);
  Report out{.exit = errors_.empty() ? Exit::done : exit_of(errors_.front().code()), .text = {}};
  out.errors = std::move(errors_);
  out.files_written = std::move(written_);
  return {{events_.kept()}, std::move(out)};
}

Answer<AgentRun> Agent::run() {
  constexpr bool kHasResult = false;
  if (const auto proven = ca_.check_ca_opens(); !proven)
    return {{}, report_of(proven.error()), kHasResult};
  events_.report("started", start_members());
  while (!signals_.is_stopped()) {
    if (signals_.take_reload()) schedule_all_now();
    if (next_end_ <= context_.clock.since_boot()) end_overlaps();
    auto& folder = *std::ranges::min_element(folders_, {}, &Folder::next);
    const auto now = context_.clock.since_boot();
    const auto rest = std::min(folder.next, next_end_) - now;
    if (folder.next <= now)
      visit(folder);
    else
      signals_.wait(-1, 0, steady_clock::now() + std::min<Moment>(rest, seconds(60)), true);
    errors_.clear();
    written_.clear();
  }
  for (auto& folder : folders_) folder.lock.reset();
  events_.report("stopped");
  return {{}, {}, kHasResult};
}

void Agent::schedule_all_now() {
  for (auto& folder : folders_) {
    folder.next = folder.next_attempt = folder.next_documents = {};
    folder.refusal.reset();
    folder.reported_refusal.clear();
    folder.limit.clear();
    folder.lasting_problem.clear();
    folder.list_warning.clear();
  }
  next_end_ = {};
  failed_ends_ = 0;
  refused_ends_.clear();
  ca_.forget_refusals();
  owners_with_wrong_pin_.clear();
  slow_owners_.clear();
  silent_responders_.clear();
  reported_list_problem_.reset();
}

// Call this before the folders are checked: once an overlap has ended, the former CA renews no
// certificate of a participant that has not moved.
void Agent::end_overlaps() {
  const auto now = context_.clock.calendar_seconds();
  auto rest = kMaxLook;
  bool are_ended = true;
  const auto overlaps = overlaps_to_end(arguments_);
  std::erase_if(refused_ends_, [&](const auto& role) {
    return std::ranges::find(overlaps, role, &OverlapToEnd::role) == overlaps.end();
  });
  for (const auto& overlap : overlaps) {
    if (signals_.is_stopped()) return;
    if (overlap.until > now) {
      rest = std::clamp(std::chrono::ceil<seconds>(overlap.until - now), seconds(1), rest);
      continue;
    }
    if (refused_ends_.contains(overlap.role)) continue;
    if (!end_overlap_and_report(overlap)) are_ended = false;
  }
  failed_ends_ = are_ended ? 0 : failed_ends_ + 1;
  next_end_ = context_.clock.since_boot() + (are_ended ? rest : kRetryEnd);
}

bool Agent::end_overlap_and_report(const OverlapToEnd& overlap) {
  auto json = ca_.end_overlap(overlap);
  if (!json) {
    if (json.error().code() == Code::interrupted && signals_.is_stopped()) return false;
    const bool is_refused = must_not_be_tried_again(json.error().code());
    if (is_refused) refused_ends_.insert(overlap.role);
    auto members = event_members(json.error());
    members["failures"] = failed_ends_ + 1;
    members["again_in"] = is_refused ? Json() : Json(kRetryEnd.count());
    events_.report("failed", arguments_.text("--ca"), std::move(members));
    errors_.push_back(json.error());
    return is_refused;
  }
  if (!writes_nothing())
    for (auto& file : files_from(*json)) written_.push_back(std::move(file));
  note_problem(*json);
  events_.report(writes_nothing() ? "overlap_due" : "overlap_ended", arguments_.text("--ca"),
                 *std::move(json));
  for (auto& folder : folders_) {  // each has new files
    folder.next = {};
    if (!folder.refusal) folder.next_attempt = {};
  }
  return true;
}

// Gives each folder the entries for participants that were renewed after it. The error of a folder
// that failed is reported already.
void Agent::complete_lists() {
  const auto list = renewal_list_text();
  if (list.empty()) return;
  for (auto& folder : folders_) {
    if (signals_.is_stopped()) return;
    if (!folder.lock || folder.task.renewals == list) continue;
    folder.task.is_only_for_list = true;
    auto event = run_worker(folder);
    folder.task.is_only_for_list = false;
    const bool is_known = folder.failures > 0 || folder.has_problem;
    if (!is_known && (!event || event->contains("problem"))) note_outcome(folder, std::move(event));
  }
}

void Agent::visit(Folder& folder) {
  folder.task.is_waiting = folder.next_attempt > context_.clock.since_boot();
  auto event = run_worker(folder);
  if (folder.task.is_waiting)
    note_waiting_visit(folder, std::move(event));
  else
    note_outcome(folder, std::move(event));
  report_list_problem();
}

void Agent::note_outcome(Folder& folder, Result<Json> event) {
  if (event) return note_success(folder, *std::move(event));
  if (event.error().code() != Code::interrupted || !signals_.is_stopped())
    note_failure(folder, event.error());
}

Result<Json> Agent::run_worker(Folder& folder) {
  const auto& path = folder.task.folder;
  if (folder.unended && !folder.unended->reap()) return unended_error(path, *folder.unended);
  folder.unended.reset();
  if (folder.lock && !folder.lock->is_in_place(path)) folder.lock.reset();
  if (!folder.lock && !folder.task.is_dry_run) {
    DDSSEC_ASSIGN_OR_RETURN(folder.lock, FolderLock::acquire(path));
  }
  if (folder.lock) {  // with --dry-run no responder is asked
    const auto owner = folder.lock->owner().user;
    folder.task.uses_no_token = owners_with_wrong_pin_.contains(owner);
    folder.task.responders = asked_responders(arguments_, owner == ::geteuid());
    folder.task.responders.silent_urls =
        silent_responders_.silent_for(owner, context_.clock.since_boot());
  }
  folder.task.renewals = renewal_list_text();
  folder.task.fetches_documents = ca_.has_document_hook() && folder.lock &&
                                  folder.next_documents <= context_.clock.since_boot();
  DDSSEC_ASSIGN_OR_RETURN(auto worker, start_worker(folder));
  const auto sent = worker.write(order_line(
      folder.task, folder.lock ? &folder.lock->folder() : nullptr,
      arguments_.has("--now") ? std::optional(context_.clock.calendar_seconds()) : std::nullopt));
  auto event = sent ? serve_worker(folder, worker) : Result<Json>(std::unexpected(sent.error()));
  if (auto unended = worker.end()) folder.unended.emplace(*std::move(unended));
  return event;
}

Result<WorkerProcess> Agent::start_worker(const Folder& folder) {
  const int lock = folder.lock ? folder.lock->descriptor() : -1;
  const auto owner = folder.lock ? std::optional(folder.lock->owner().user) : std::nullopt;
  const bool is_own = owner == ::geteuid();
  DDSSEC_ASSIGN_OR_RETURN(
      auto process, ChildProcess::start(
                        signals_,
                        [&](int in, int out) {
                          return become_worker(worker_variables(is_own, arguments_), in, out, lock);
                        },
                        lock));
  return WorkerProcess(std::move(process), owner, slow_owners_, context_.clock);
}

std::string Agent::renewal_list_text() {
  if (ca_.has_certificate_hook()) return {};
  auto list = renewal_list_of_ca(arguments_);
  list_problem_ = std::move(list.problem);
  return std::move(list.text);
}

// Called after a visit, because a renewal begins a new list in place of one that cannot be read,
// and says so itself.
void Agent::report_list_problem() {
  const auto code = list_problem_ ? std::optional(list_problem_->code()) : std::nullopt;
  if (code == std::exchange(reported_list_problem_, code) || !list_problem_) return;
  auto members = event_members(*list_problem_);
  members["failures"] = 1;
  members["again_in"] = kMaxRest.count();
  events_.report("failed", arguments_.text("--ca"), std::move(members));
  errors_.push_back(*list_problem_);
}

// Lets the other folders get the list with the new certificate soon, unless there are too many.
void Agent::schedule_others(const Folder& renewed) {
  constexpr std::size_t kMax = 64;
  if (ca_.has_certificate_hook() || folders_.size() > kMax) return;
  const auto soon = context_.clock.since_boot() + seconds(1);
  for (auto& other : folders_)
    if (&other != &renewed && other.failures == 0) other.next = std::min(other.next, soon);
}

// Answers the worker's questions about documents, which come first. Returns the first line that is
// about something else. The error of a document is sent as the answer and does not end the worker.
Result<Json> Agent::answer_documents(Folder& folder, WorkerProcess& worker) {
  // The worker asks at most once for each of three kinds of document, and then reports the outcome.
  constexpr int kMaxLines = 4;
  for (int lines = 0;; ++lines) {
    DDSSEC_ASSIGN_OR_RETURN(auto json, worker.read());
    const bool is_outcome = json.contains("documents");
    if (!is_outcome && !json.contains("wanted")) return json;
    if (lines == kMaxLines || !folder.task.fetches_documents) return protocol_error();
    if (is_outcome) {
      note_documents(folder, json["documents"]);
      continue;
    }
    const auto document =
        ca_.document(folder.task.folder, folder.lock->folder(), document_request_from(json));
    if (!document && signals_.is_stopped()) return std::unexpected(document.error());
    const auto answer = document ? document_line(*document) : error_line(document.error());
    DDSSEC_RETURN_IF_ERROR(worker.write(to_line(answer) + '\n'));
  }
}

// The folder's worker says when to ask again. For a folder of another user the agent waits at least
// kMinRestOfOthers.
void Agent::note_documents(Folder& folder, const Json& outcome) {
  const bool is_own = folder.lock->owner().user == ::geteuid();
  const auto now = context_.clock.calendar_seconds();
  const auto next = time_from(text_in(outcome, "documents_next"));
  const auto rest = std::clamp(next.value_or(now + kMaxRest) - now,
                               is_own ? seconds(1) : kMinRestOfOthers, kMaxRest);
  folder.next_documents = context_.clock.since_boot() + rest;
  auto members = known_members(outcome);
  for (auto& file : files_from(members)) written_.push_back(std::move(file));
  note_lasting_problem(folder, members);
  note_problem(members);
  if (members.empty()) return;
  if (!members.contains("files")) members["files"] = Json::array();
  events_.report("documents_fetched", folder.task.folder, std::move(members));
}

// A problem of the documents that stays until the operator acts is reported once a day, and removed
// from the members otherwise. Others are reported at each attempt.
void Agent::note_lasting_problem(Folder& folder, Json& members) {
  if (!members.contains("problem")) return folder.lasting_problem.clear();
  const auto code = reported_error(members["problem"]).code();
  // Asking for permissions needs the participant's key.
  if (must_not_be_tried_again(code)) owners_with_wrong_pin_.insert(folder.lock->owner().user);
  if (!must_not_be_tried_again(code) && code != tool_code::no_new_permissions) return;
  if (!folder.lasting_problem.note(code, context_.clock.since_boot())) members.erase("problem");
}

// The worker asks the CA at most once. After an error it gets its code, because it still keeps the
// list and the response for the peers. The details may not be for the folder's owner.
Result<Json> Agent::serve_worker(Folder& folder, WorkerProcess& worker) {
  DDSSEC_ASSIGN_OR_RETURN(const auto json, answer_documents(folder, worker));
  if (!json.contains("request")) return outcome_after(folder, worker, json);
  DDSSEC_ASSIGN_OR_RETURN(const auto request, request_from(json));
  const bool is_own = folder.lock && folder.lock->owner().user == ::geteuid();
  if (is_own) folder.lifetime = std::max(seconds(1), request.lifetime);
  auto answer = ask_ca(folder, request);
  if (!answer) {
    const auto line = to_line(error_line(Error(answer.error().code()))) + '\n';
    if (!signals_.is_stopped()) std::ignore = finish_worker(folder, worker, line);
    return std::unexpected(answer.error());
  }
  note_answer(folder, *answer);
  answer->renewals = renewal_list_text();  // includes the new certificate
  DDSSEC_ASSIGN_OR_RETURN(auto event, finish_worker(folder, worker, answer_line(*answer)));
  if (ca_.has_certificate_hook()) folder.limit.note(folder.lifetime, context_.clock.since_boot());
  if (answer->notice && !event.contains("problem"))
    event["problem"] = error_to_json(*answer->notice);
  if (!answer->renewals.empty()) folder.task.renewals = std::move(answer->renewals);
  return event;
}

Result<Json> Agent::finish_worker(const Folder& folder, WorkerProcess& worker,
                                  std::string_view answer) {
  DDSSEC_RETURN_IF_ERROR(worker.write(answer));
  DDSSEC_ASSIGN_OR_RETURN(const auto line, worker.read());
  return outcome_after(folder, worker, line);
}

// A worker reports a renewal when the files are in place, or else the error. It reports the outcome
// again at its end. If it is killed in between, the first report counts.
Result<Json> Agent::outcome_after(const Folder& folder, WorkerProcess& worker, const Json& line) {
  const bool is_renewed = line.contains("renewed");
  if (!is_renewed && !line.contains("failed")) return outcome_from(folder, line);
  const auto last = worker.read();
  auto outcome = last ? outcome_from(folder, *last) : Result<Json>(std::unexpected(last.error()));
  if (!is_renewed) return std::unexpected(reported_error(line["failed"]));
  if (last) return outcome;
  auto renewed = known_members(line["renewed"]);
  if (!signals_.is_stopped() && !renewed.contains("problem"))
    renewed["problem"] = error_to_json(last.error());
  return renewed;
}

Result<Json> Agent::outcome_from(const Folder& folder, const Json& line) {
  auto members = known_members(line);
  if (folder.lock)
    silent_responders_.note(folder.lock->owner().user, text_in(members, "ocsp_silent"),
                            context_.clock.since_boot());
  members.erase("ocsp_silent");
  if (!line.contains("error")) return members;
  for (auto& file : files_from(members)) written_.push_back(std::move(file));
  return std::unexpected(reported_error(line["error"]));
}

Result<RenewalAnswer> Agent::ask_ca(const Folder& folder, const RenewalRequest& request) {
  if (!folder.lock) return protocol_error();  // with --dry-run the CA is not asked
  if (!folder.limit.allows(context_.clock.since_boot()))
    return fail(tool_code::renewed_too_often, {.document = folder.task.folder});
  return ca_.renew(folder.task.folder, folder.lock->folder(), request);
}

// The lifetime is read from what the CA signed: a worker may run code of the folder's owner. The
// answer of a CA of this machine is in its log, even if the worker does not accept it.
void Agent::note_answer(Folder& folder, const RenewalAnswer& answer) {
  const auto certificate = pki::Certificate::from_pem(as_bytes(answer.certificate));
  if (certificate) folder.lifetime = lifetime(*certificate);
  if (!ca_.has_certificate_hook()) folder.limit.note(folder.lifetime, context_.clock.since_boot());
}

bool Agent::note_problem(Json& event) {
  if (!event.contains("problem")) return false;
  const auto problem = reported_error(event["problem"]);
  event["problem"] = event_members(problem);
  if (problem.code() == Code::crl_ends_soon)
    return false;  // a warning is no failure of the command
  errors_.push_back(problem);
  return true;
}

// A list that ends soon needs no other visit. Without this, the warning would be repeated at each
// visit for a sixth of the list's time.
void Agent::leave_out_repeated_warning(Folder& folder, Json& event) {
  const auto code = event.contains("problem") ? reported_error(event["problem"]).code() : Code{};
  if (code != Code::crl_ends_soon) return folder.list_warning.clear();
  if (!folder.list_warning.note(code, context_.clock.since_boot())) event.erase("problem");
}

void Agent::note_success(Folder& folder, Json event) {
  const auto name = text_in(event, "event");
  const auto next = time_from(text_in(event, "next"));
  folder.failures = 0;
  folder.next_attempt = {};
  folder.refusal.reset();
  const auto now = context_.clock.calendar_seconds();
  const auto rest = std::clamp(next.value_or(now) - now, seconds(1), kMaxRest);
  folder.next = context_.clock.since_boot() + rest;
  if (ca_.has_document_hook() && folder.next_documents > Moment(0))
    folder.next = std::min(folder.next, folder.next_documents);
  if (name == "renewed") {
    folder.task.known = text_in(event, "sha256");
    folder.task.known_renewal = next.value_or(now);
    schedule_others(folder);
  }
  for (auto& file : files_from(event)) written_.push_back(std::move(file));
  leave_out_repeated_warning(folder, event);
  const bool is_news = name != "current" || event.contains("problem") ||
                       folder.last_reported_serial != text_in(event, "serial");
  folder.last_reported_serial = text_in(event, "serial");
  folder.has_problem = note_problem(event);
  event.erase("event");
  if (is_news) events_.report(name, folder.task.folder, std::move(event));
}

void Agent::note_failure(Folder& folder, const Error& error) {
  ++folder.failures;
  const bool is_refused = must_not_be_tried_again(error.code());
  const bool is_refused_by_ca = is_refused && ca_.has_refusal(error);
  // Without the permissions CA the certificate is renewed nevertheless, once it is due.
  const bool is_paused = is_refused && (!is_refused_by_ca || ca_.is_refused());
  folder.refusal = is_paused ? std::optional(error) : std::nullopt;
  if (is_refused && !is_refused_by_ca && folder.lock)
    owners_with_wrong_pin_.insert(folder.lock->owner().user);
  std::array<std::uint8_t, 1> jitter{};
  static_cast<void>(context_.random.fill(jitter));
  const auto wait = retry_after(folder.failures, folder.lifetime, jitter[0]);
  const auto now = context_.clock.since_boot();
  folder.next_attempt = is_paused ? Moment::max() : now + wait;
  schedule_waiting(folder);
  if (is_paused) folder.reported_refusal.note(error.code(), now);
  report_failure(folder, error, is_paused ? Json() : Json(wait.count()));
  errors_.push_back(error.with_default_document(folder.task.folder));
}

void Agent::report_failure(const Folder& folder, const Error& error, Json again_in) {
  auto members = event_members(error);
  members["failures"] = folder.failures;
  members["again_in"] = std::move(again_in);
  events_.report("failed", folder.task.folder, std::move(members));
}

// While a renewal waits, the folder is visited for its lists and its OCSP response.
void Agent::schedule_waiting(Folder& folder) {
  const auto now = context_.clock.since_boot();
  folder.next = std::min<Moment>(folder.next_attempt, now + kMaxRest);
  if (ca_.has_document_hook() && folder.next_documents > now)
    folder.next = std::min(folder.next, folder.next_documents);
}

// The reason for the wait is reported already, and once more each day if only SIGHUP ends it.
void Agent::note_waiting_visit(Folder& folder, Result<Json> event) {
  if (event && text_in(*event, "event") != "due")  // the operator has renewed it by hand
    return note_success(folder, *std::move(event));
  schedule_waiting(folder);
  const auto now = context_.clock.since_boot();
  if (folder.refusal && folder.reported_refusal.note(folder.refusal->code(), now))
    report_failure(folder, *folder.refusal, Json());
}

}  // namespace ddssec::cli
