#include "cli/agent/agent_worker.hpp"

#include <algorithm>
#include <array>
#include <fcntl.h>
#include <string_view>
#include <sys/prctl.h>
#include <unistd.h>

#include "cli/frame/interruption.hpp"
#include "cli/frame/new_file.hpp"
#include "pki/token_logins.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The numbers of the worker's files, after standard error.
constexpr int kIn = 3;
constexpr int kOut = 4;
constexpr int kLock = 5;
constexpr int kNotStarted = 127;

constexpr std::array<std::string_view, 7> kPlacesOfLibraries = {
    "LD_LIBRARY_PATH", "LD_PRELOAD",         "OPENSSL_CONF",  "OPENSSL_ENGINES",
    "OPENSSL_MODULES", "PKCS11_MODULE_PATH", "SOFTHSM2_CONF",
};

std::unexpected<Error> agent_ended_error() {
  return fail(Code::internal, {.field = "the agent", .note = "it has ended"});
}

// Duplicates `file` to a number above kLock, so that the dup2() calls that follow overwrite no file
// that is still to be copied.
int duplicate_above_reserved(int file) { return file < 0 ? -1 : ::fcntl(file, F_DUPFD, kLock + 1); }

bool arrange_files(int in, int out, int lock) {
  const std::array<int, 3> from = {duplicate_above_reserved(in), duplicate_above_reserved(out),
                                   duplicate_above_reserved(lock)};
  if (from[0] < 0 || from[1] < 0 || (lock >= 0 && from[2] < 0)) return false;
  const bool are_placed = ::dup2(from[0], kIn) >= 0 && ::dup2(from[1], kOut) >= 0 &&
                          (lock < 0 ? (::close(kLock), true) : ::dup2(from[2], kLock) >= 0);
  const int nothing = ::open("/dev/null", O_RDWR);
  const bool are_closed = nothing >= 0 && ::dup2(nothing, STDIN_FILENO) >= 0 &&
                          ::dup2(nothing, STDOUT_FILENO) >= 0 &&
                          ::dup2(nothing, STDERR_FILENO) >= 0;
  return are_placed && are_closed && ::close_range(kLock + 1, ~0U, 0) == 0;
}

Result<std::string> receive(int in) {
  std::string out;
  std::array<char, 4096> part{};
  while (out.size() <= kMaxAgentLine && !out.ends_with('\n')) {
    const auto size = ::read(in, part.data(), part.size());
    DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
    if (size <= 0) return agent_ended_error();
    out.append(part.data(), static_cast<std::size_t>(size));
  }
  return out;
}

// The content of order_line(), as a worker reads it.
struct Order {
  AgentTask task;
  std::optional<LockedFolder> locked = {};
  std::optional<WallTime> now = {};
};

WallTime time_in(const Json& json, const char* name) {
  return WallTime(std::chrono::seconds(number_in(json, name)));
}

bool is_set(const Json& json, const char* name) { return number_in(json, name) != 0; }

LockedFolder locked_from(const Json& json) {
  return {.owner = {static_cast<uid_t>(number_in(json, "user")),
                    static_cast<gid_t>(number_in(json, "group"))},
          .device = static_cast<dev_t>(number_in(json, "device")),
          .inode = static_cast<ino_t>(number_in(json, "inode"))};
}

AskedResponders responders_from(const Json& json) {
  AskedResponders out{.cas_pem = text_in(json, "cas"),
                      .cas_source = text_in(json, "cas_from"),
                      .asks_none = is_set(json, "ask_none")};
  for (const auto& url : json["not_now"])
    if (url.is_string()) out.silent_urls.push_back(url.get<std::string>());
  return out;
}

Result<Order> receive_order() {
  DDSSEC_ASSIGN_OR_RETURN(const auto line, receive(kIn));
  DDSSEC_ASSIGN_OR_RETURN(const auto json, json_from(line));
  const auto folder = from_hex(text_in(json, "folder"));
  if (!folder) return agent_ended_error();
  Order out{.task = {.folder = fs::path(std::string(as_text(*folder))),
                     .is_rekeying = is_set(json, "rekey"),
                     .takes_permissions = is_set(json, "permissions"),
                     .is_dry_run = is_set(json, "dry_run"),
                     .uses_no_token = is_set(json, "no_token"),
                     .known = text_in(json, "known"),
                     .known_renewal = time_in(json, "known_renewal"),
                     .responders = responders_from(json),
                     .renewals = text_in(json, "renewals"),
                     .fetches_documents = is_set(json, "documents"),
                     .is_only_for_list = is_set(json, "only_list"),
                     .is_waiting = is_set(json, "waiting")}};
  if (json.contains("now")) out.now = time_in(json, "now");
  if (json.contains("locked")) out.locked = locked_from(json["locked"]);
  return out;
}

// Sends a line to the agent and returns its answer.
Result<Json> exchange(const Json& line) {
  if (send_line(kOut, line) != 0) return agent_ended_error();
  DDSSEC_ASSIGN_OR_RETURN(const auto answer, receive(kIn));
  return json_from(answer);
}

AgentServices services() {
  return {.ask = [](const RenewalRequest& request) -> Result<RenewalAnswer> {
            DDSSEC_ASSIGN_OR_RETURN(const auto json, exchange(to_json(request)));
            return answer_from(json);
          },
          .fetch = [](const DocumentRequest& request) -> Result<Bytes> {
            DDSSEC_ASSIGN_OR_RETURN(const auto json, exchange(to_json(request)));
            return document_from(json);
          },
          .report_documents =
              [](const Json& documents) {
                send_line(kOut, {{"documents", documents}});
              },
          .report_renewed =
              [](const Json& event) {
                send_line(kOut, {{"renewed", event}});
              },
          .report_failed =
              [](const Error& error) {
                send_line(kOut, {{"failed", error_to_json(error)}});
              }};
}

Result<Json> work() {
  DDSSEC_ASSIGN_OR_RETURN(const auto order, receive_order());
  if (order.task.is_dry_run) write_nothing();
  const SystemClock present;
  const ManualClock given(order.now.value_or(WallTime()));
  SystemRandom random;
  const Context context{order.now ? static_cast<const Clock&>(given) : present, random};
  return maintain_folder(order.task, order.locked ? &*order.locked : nullptr, services(), context);
}

bool is_named(std::string_view variable, std::string_view name) {
  return variable.starts_with(name) && variable.substr(name.size()).starts_with('=');
}

bool is_one_of(std::string_view variable, const auto& names) {
  return std::ranges::any_of(names, [&](const auto& name) { return is_named(variable, name); });
}

}  // namespace

std::vector<std::string> worker_variables(bool is_own, const Arguments& arguments) {
  // Only the process that asks the CA, and the hook, need these.
  auto secret = arguments.all("--hook-env");
  if (arguments.has("--passphrase-env")) secret.push_back(arguments.text("--passphrase-env"));
  std::vector<std::string> out;
  if (!is_own) {
    out.emplace_back("PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin");
    out.emplace_back("LC_ALL=C.UTF-8");
    out.emplace_back("HOME=/nonexistent");
  }
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (is_one_of(*variable, secret)) continue;
    if (is_own || is_one_of(*variable, kPlacesOfLibraries)) out.emplace_back(*variable);
  }
  return out;
}

int become_worker(std::vector<std::string> variables, int in, int out, int lock) {
  if (!arrange_files(in, out, lock)) return kNotStarted;
  std::vector<char*> pointers;
  for (auto& variable : variables) pointers.push_back(variable.data());
  pointers.push_back(nullptr);
  std::array<std::string, 2> words = {"ddssec", kAgentWorker};
  const std::array<char*, 3> arguments = {words[0].data(), words[1].data(), nullptr};
  ::execve("/proc/self/exe", arguments.data(), pointers.data());
  return kNotStarted;
}

std::string order_line(const AgentTask& task, const LockedFolder* locked,
                       std::optional<WallTime> now) {
  Json out = {{"folder", to_hex(as_bytes(task.folder.string()))},
              {"rekey", int(task.is_rekeying)},
              {"permissions", int(task.takes_permissions)},
              {"dry_run", int(task.is_dry_run)},
              {"no_token", int(task.uses_no_token)},
              {"known", task.known},
              {"known_renewal", task.known_renewal.time_since_epoch().count()},
              {"cas", task.responders.cas_pem},
              {"cas_from", task.responders.cas_source},
              {"ask_none", int(task.responders.asks_none)},
              {"not_now", task.responders.silent_urls},
              {"renewals", task.renewals},
              {"documents", int(task.fetches_documents)},
              {"only_list", int(task.is_only_for_list)},
              {"waiting", int(task.is_waiting)}};
  if (now) out["now"] = now->time_since_epoch().count();
  if (locked != nullptr)
    out["locked"] = {{"user", locked->owner.user},
                     {"group", locked->owner.group},
                     {"device", locked->device},
                     {"inode", locked->inode}};
  return to_line(out) + '\n';
}

void run_agent_worker() {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  note_interruptions();
  pki::stop_at_first_wrong_pin();
  const auto event = work();
  auto line = event ? *event : error_line(event.error());
  if (event && !line.contains("error")) add_notice_to(line, "problem");
  ::_exit(send_line(kOut, line));
}

}  // namespace ddssec::cli
