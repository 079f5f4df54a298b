#include "cli/agent/agent_hook.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/folder_rights.hpp"
#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/agent/hook_messages.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using End = ChildProcess::End;

constexpr int kNotStarted = 127;

std::unexpected<Error> invalid_hook_error(const std::string& option, std::string expected,
                                          std::string found) {
  return fail(Code::usage, {.field = option,
                            .expected = std::move(expected),
                            .found = '"' + std::move(found) + '"',
                            .note = "no shell reads it: write a script for more"});
}

Result<std::vector<std::string>> words_of(const std::string& option, const std::string& text) {
  constexpr std::string_view kOfShells = "\"'\\$`;|&<>()*?[]{}~#!\n\r\t";
  if (text.find_first_of(kOfShells) != text.npos)
    return invalid_hook_error(
        option, "words that are separated by blanks, without characters of a shell", text);
  std::vector<std::string> out;
  for (std::size_t at = 0; (at = text.find_first_not_of(' ', at)) != text.npos;) {
    const auto end = std::min(text.find(' ', at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end;
  }
  if (out.empty() || !out.front().starts_with('/'))
    return invalid_hook_error(option, "the absolute path of a program, and its arguments", text);
  return out;
}

Result<std::vector<std::string>> variables_of(const Arguments& arguments) {
  std::vector<std::string> out;
  for (const auto& name : arguments.all("--hook-env")) {
    const char* value = std::getenv(name.c_str());
    if (value == nullptr)
      return fail(Code::usage, {.field = "--hook-env",
                                .expected = "the name of a variable that is set",
                                .found = '"' + name + '"'});
    out.push_back(name + '=' + value);
  }
  return out;
}

// In a folder with the sticky bit only the owner of a file can replace it. `file` was resolved
// before, so a symbolic link in its path was put there since.
Status check_place(const fs::path& file, Code unsafe) {
  const auto open = open_folder_above(file.parent_path());
  if (!open) return {};
  return fail(unsafe, {.document = *open,
                       .expected = fmt::format("a folder of root or of this user that no other "
                                               "user can write, since {} is in it",
                                               file.string()),
                       .found = owner_and_mode(*open)});
}

// `file` is a path without symbolic links.
Status check_file(const fs::path& file, Code unsafe, Code unreadable) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0)
    return fail(unreadable, {.document = file, .note = errno_text(errno)});
  if (S_ISREG(status.st_mode) && is_of_trusted_owner(status) && !others_may_write(status))
    return check_place(file, unsafe);
  return fail(unsafe, {.document = file,
                       .expected = "a file of root or of this user that no other user can write",
                       .found = owner_and_mode(file)});
}

// The standard files of a hook.
struct HookFiles {
  int in, out, errors;
};

bool arrange(const HookFiles& files) {
  if (::dup2(files.in, STDIN_FILENO) < 0 || ::dup2(files.out, STDOUT_FILENO) < 0 ||
      ::dup2(files.errors, STDERR_FILENO) < 0)
    return false;
  for (const int file : {files.in, files.out, files.errors}) ::close(file);
  return true;
}

int become_hook(Hook hook, const fs::path& program, const HookRequest& request,
                const HookFiles& files) {
  auto variables = std::move(hook.variables);
  variables.emplace_back("PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin");
  variables.emplace_back("LC_ALL=C.UTF-8");
  variables.push_back("DDSSEC_FOLDER=" + request.folder.string());
  variables.push_back("DDSSEC_SUBJECT=" + request.subject);
  if (!request.wanted.empty()) variables.push_back("DDSSEC_WANTED=" + request.wanted);
  ::signal(SIGPIPE, SIG_DFL);
  if (::chdir("/") != 0 || !arrange(files)) return kNotStarted;
  ::execve(program.c_str(), argument_pointers(hook.words).data(),
           argument_pointers(variables).data());
  return kNotStarted;
}

std::unexpected<Error> hook_ended_error(End end, const Hook& hook, std::size_t max_answer) {
  const auto& program = hook.words.front();
  if (end == End::stopped) return fail(Code::interrupted);
  if (end == End::too_long)
    return fail(tool_code::hook_too_long,
                {.document = program, .expected = fmt::format("at most {} octets", max_answer)});
  return fail(
      tool_code::hook_too_slow,
      {.document = program, .expected = fmt::format("an end within {} s", hook.timeout.count())});
}

}  // namespace

Result<Hook> hook_of(const Arguments& arguments, const std::string& option) {
  constexpr int kMax = 3600;
  DDSSEC_ASSIGN_OR_RETURN(auto words, words_of(option, arguments.text(option)));
  DDSSEC_ASSIGN_OR_RETURN(auto variables, variables_of(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const int seconds, arguments.number("--hook-timeout", 1, kMax));
  return Hook{std::move(words), std::move(variables), std::chrono::seconds(seconds)};
}

Status check_trust_file(const fs::path& file) {
  std::error_code error;
  const auto path = fs::canonical(file, error);
  if (error) return fail(Code::file_unreadable, {.document = file, .note = error.message()});
  return check_file(path, tool_code::trust_unsafe, Code::file_unreadable);
}

// A hook need not read the request, so it is no failure if it closes its input.
Result<std::string> run_hook(const Hook& hook, const HookRequest& request, HeldSignals& signals) {
  std::error_code error;
  const auto program = fs::canonical(hook.words.front(), error);
  if (error)
    return fail(tool_code::hook_failed, {.document = hook.words.front(), .note = error.message()});
  // A user who can change the program would get the rights of the agent.
  DDSSEC_RETURN_IF_ERROR(check_file(program, tool_code::hook_unsafe, tool_code::hook_failed));
  const auto deadline = std::chrono::steady_clock::now() + hook.timeout;
  HookMessages messages(signals);
  const auto become = [&](int in, int out) {
    return become_hook(hook, program, request, {in, out, messages.hook_end()});
  };
  DDSSEC_ASSIGN_OR_RETURN(auto child, ChildProcess::start(signals, become, messages.hook_end()));
  messages.close_hook_end();
  const auto sent = child.write(request.input, deadline);
  if (sent != End::done && sent != End::closed)
    return hook_ended_error(sent, hook, request.max_answer);
  child.end_input();
  std::string out;
  if (const auto end = child.read_all(out, request.max_answer, deadline); end != End::done)
    return hook_ended_error(end, hook, request.max_answer);
  if (const auto end = child.wait(deadline); end != End::done)
    return hook_ended_error(end, hook, request.max_answer);
  if (child.failure().empty()) return out;
  return fail(
      tool_code::hook_failed,
      {.document = hook.words.front(), .expected = "exit code 0", .found = child.failure()});
}

}  // namespace ddssec::cli
