#include "cli/inputs/passphrase.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/hash.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/interruption.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPassphraseLine = pki::Passphrase::capacity + 2;

std::string_view without_line_end(std::string_view text) {
  if (text.ends_with('\n')) text.remove_suffix(1);
  if (text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

Result<pki::Passphrase> passphrase_from(std::string_view text) {
  if (text.empty() || text.size() > pki::Passphrase::capacity)
    return fail(Code::passphrase_unusable);
  return pki::Passphrase::copy_of(as_bytes(text));
}

// Reads one line octet by octet, because the rest of the stream does not belong to this command.
Result<pki::Passphrase> passphrase_from_stream(int file) {
  std::array<std::uint8_t, kMaxPassphraseLine> line{};
  std::size_t size = 0;
  while (size < line.size() && ::read(file, &line[size], 1) == 1)
    if (line[size++] == '\n') break;
  auto out = passphrase_from(without_line_end(as_text(BytesView(line).first(size))));
  wipe(line);
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  return out;
}

// Reads from a pipe of the shell, such as --passphrase-file <(pass show ca).
Result<pki::Passphrase> passphrase_from_pipe(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return fail(Code::file_unreadable, {.document = path, .note = errno_text(errno)});
  auto out = passphrase_from_stream(file);
  ::close(file);
  return out;
}

Result<pki::Passphrase> passphrase_from_file(const std::string& path) {
  if (path == "-") return passphrase_from_stream(STDIN_FILENO);
  std::error_code ignored;
  if (fs::is_fifo(path, ignored)) return passphrase_from_pipe(path);
  DDSSEC_ASSIGN_OR_RETURN(auto octets, read_file(path, kMaxPassphraseLine));
  auto out = passphrase_from(without_line_end(as_text(octets)));
  wipe(octets);
  return out;
}

class EchoGuard {
 public:
  EchoGuard() {
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    auto quiet = before_;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    known_ = ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet) == 0;
  }
  ~EchoGuard() {
    if (known_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
    std::fputc('\n', stderr);
  }
  EchoGuard(const EchoGuard&) = delete;
  EchoGuard& operator=(const EchoGuard&) = delete;

 private:
  termios before_{};
  bool known_ = false;
};

Result<pki::Passphrase> typed_passphrase(const char* prompt) {
  std::fputs(prompt, stderr);
  const EchoGuard echo_off;
  return passphrase_from_stream(STDIN_FILENO);
}

// Empty if neither option is given.
std::optional<Result<pki::Passphrase>> given_passphrase(const Arguments& arguments) {
  if (arguments.has("--passphrase-file"))
    return passphrase_from_file(arguments.text("--passphrase-file"));
  if (!arguments.has("--passphrase-env")) return std::nullopt;
  const auto name = arguments.text("--passphrase-env");
  if (const char* value = std::getenv(name.c_str())) return passphrase_from(value);
  return fail(Code::passphrase_unusable,
              {.note = "the environment variable " + name + " is not set",
               .hint = "set and export it; or give --passphrase-file FILE"});
}

Status check_terminal() {
  const bool is_terminal = ::isatty(STDIN_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0;
  return is_terminal ? Status{} : fail(Code::passphrase_needed);
}

}  // namespace

Result<pki::Passphrase> passphrase(const Arguments& arguments, const char* prompt) {
  if (auto given = given_passphrase(arguments)) return *std::move(given);
  DDSSEC_RETURN_IF_ERROR(check_terminal());
  return typed_passphrase(prompt);
}

Result<pki::Passphrase> new_passphrase(const Arguments& arguments) {
  if (auto given = given_passphrase(arguments)) return *std::move(given);
  DDSSEC_RETURN_IF_ERROR(check_terminal());
  DDSSEC_ASSIGN_OR_RETURN(auto first, typed_passphrase("passphrase of the CA key: "));
  DDSSEC_ASSIGN_OR_RETURN(const auto second, typed_passphrase("the same again: "));
  return first == second ? Result<pki::Passphrase>(std::move(first))
                         : fail(Code::passphrase_unusable);
}

std::optional<Error> passphrase_warning(const Arguments& arguments) {
  if (!arguments.has("--passphrase-file")) return std::nullopt;
  const auto path = arguments.text("--passphrase-file");
  struct stat status {};
  if (path == "-" || ::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) ||
      (status.st_mode & 077) == 0)
    return std::nullopt;
  return Error(Code::passphrase_readable_by_others,
               {.document = path,
                .expected = "mode 0600",
                .found = fmt::format("mode {:04o}", status.st_mode & 07777)});
}

Status confirm(const std::string& question) {
  if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDERR_FILENO) == 0)
    return fail(Code::confirmation_needed, {.note = question});
  std::fputs(fmt::format("{} [y/N] ", question).c_str(), stderr);
  char answer = 0;
  const bool said = ::read(STDIN_FILENO, &answer, 1) == 1;
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (said && (answer == 'y' || answer == 'Y')) return {};
  return fail(tool_code::not_confirmed, {.note = question});
}

}  // namespace ddssec::cli
