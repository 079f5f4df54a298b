// ddssec: the command line tool.
#include <algorithm>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <langinfo.h>
#include <string>
#include <unistd.h>
#include <vector>

#include "base/errno_text.hpp"
#include "base/text.hpp"
#include "cli/agent/agent_worker.hpp"
#include "cli/frame/explain_severities.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/notices.hpp"
#include "cli/frame/parsed_command.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/passphrase.hpp"
#include "cli/inputs/times.hpp"
#include "pki/token_logins.hpp"

namespace {

using namespace ddssec;

// Names from files must not reach a terminal, or a log that is later shown on a terminal, as
// control sequences. A terminal must also receive no octets that it does not interpret as letters.
void print(std::FILE* to, const std::string& text) {
  static const bool is_utf8 = std::string_view(::nl_langinfo(CODESET)) == "UTF-8";
  const bool letters = is_utf8 || ::isatty(::fileno(to)) != 1;
  const auto shown = printable(
      text, {.keeps_line_feeds = true, .keeps_escapes = to == stderr, .keeps_utf8 = letters});
  std::fwrite(shown.data(), 1, shown.size(), to);
}

// Works also for a command line that cannot be parsed.
bool wants_json(const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (ascii_lower(words[i]) == "--format=json") return true;
    if (words[i] == "--format" && i + 1 < words.size() && ascii_lower(words[i + 1]) == "json")
      return true;
  }
  return false;
}

Result<WallTime> time_of(const cli::Arguments& arguments) {
  const auto now = SystemClock().calendar_seconds();
  if (!arguments.has("--now")) return now;
  const auto text = arguments.text("--now");
  if (const auto time = cli::time_from(text, now)) return *time;
  return fail(Code::usage, {.field = "--now",
                            .expected = "a time such as 2026-11-21T00:00:00Z, a date, +30d or -2d",
                            .found = text});
}

Result<bool> color_of(const cli::Arguments& arguments) {
  const auto when = arguments.text("--color");
  if (when == "always" || when == "never") return when == "always";
  if (when != "auto")
    return fail(Code::usage,
                {.field = "--color", .expected = "auto, always or never", .found = when});
  const char* no_color = std::getenv("NO_COLOR");  // no-color.org: any text that is not empty
  const char* terminal = std::getenv("TERM");
  return ::isatty(STDERR_FILENO) == 1 && (no_color == nullptr || *no_color == '\0') &&
         terminal != nullptr && std::string_view(terminal) != "dumb";
}

Result<cli::Style> style_of(const cli::Arguments& arguments) {
  const bool quiet = arguments.has("--quiet"), verbose = arguments.has("--verbose");
  if (quiet && verbose)
    return fail(Code::usage, {.field = "--quiet", .note = "not together with --verbose"});
  DDSSEC_ASSIGN_OR_RETURN(const auto color, color_of(arguments));
  return cli::Style{color, quiet, verbose};
}

Result<cli::Report> run(const cli::ParsedCommand& request) {
  const auto format = request.arguments.text("--format");
  if (format != "text" && format != "json")
    return fail(Code::usage, {.field = "--format", .expected = "text or json", .found = format});
  DDSSEC_ASSIGN_OR_RETURN(const auto time, time_of(request.arguments));
  const ManualClock clock(time);
  SystemRandom random;
  if (request.arguments.has("--dry-run")) cli::write_nothing();
  if (request.arguments.has("--quiet")) cli::hide_progress();
  DDSSEC_ASSIGN_OR_RETURN(auto report, request.command->run(request.arguments, {clock, random}));
  if (auto warning = cli::passphrase_warning(request.arguments))
    report.errors.push_back(std::move(*warning));
  cli::report_notices(report);
  // An error beside a result means that a part of what the command writes could not be written.
  const auto is_error = [](const Error& one) {
    return cli::severity_in_tool(one.code()) >= Severity::error;
  };
  if (report.exit == cli::Exit::done && std::ranges::any_of(report.errors, is_error))
    report.exit = cli::Exit::failed;
  return report;
}

// The text for standard output. With --quiet a command that wrote files without a problem prints
// nothing about them; answers are still printed.
std::string text_of(const cli::Report& report, cli::Style style) {
  const bool has_written = !report.files_written.empty();
  if (has_written && cli::writes_nothing()) return cli::dry_run_text(report);
  return style.quiet && has_written && report.exit == cli::Exit::done ? "" : report.text;
}

enum class Format : std::uint8_t { text, json };

int finish(const cli::Report& report, std::string_view command, Format format, cli::Style style) {
  if (format == Format::json) {
    auto out = cli::envelope(report, command);
    if (cli::writes_nothing()) out["dry_run"] = true;
    // Writes ASCII only, so that the text cannot control a terminal.
    print(stdout, out.dump(1, ' ', true, cli::Json::error_handler_t::replace) + "\n");
  } else {
    print(stdout, text_of(report, style));
    std::fflush(stdout);  // both streams may go to one file
    print(stderr, cli::diagnostics_text(report, style));
  }
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return static_cast<int>(report.exit);
  const Error unwritten(Code::file_unwritable,
                        {.document = "standard output",
                         .note = errno_text(errno),
                         .hint = "the answer is incomplete: run the command again with an output "
                                 "that has room and is not closed"});
  print(stderr, cli::diagnostics_text(cli::report_of(unwritten), style));
  return static_cast<int>(cli::Exit::failed);
}

cli::Report failed(const Error& error, const std::vector<std::string>& words) {
  auto report = cli::report_of(error);
  cli::report_notices(report);
  report.help_on = cli::command_named(words);
  return report;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 1 && words.front() == cli::kAgentWorker) cli::run_agent_worker();
  std::setlocale(LC_CTYPE, "");  // to learn which letters the terminal accepts
  cli::note_interruptions();
  pki::stop_at_first_wrong_pin();
  const auto request = cli::parse(words);
  const auto format = wants_json(words) ? Format::json : Format::text;
  if (!request) return finish(failed(request.error(), words), "", format, {});
  if (request->command == nullptr) return finish({.text = request->help}, "", Format::text, {});
  const auto style = style_of(request->arguments);
  const auto report = style ? run(*request) : std::unexpected(style.error());
  return finish(report ? *report : failed(report.error(), words), request->command->full_name(),
                format, style.value_or(cli::Style()));
}
