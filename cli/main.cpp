// ddssec: the command line tool.
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "cli/parse.hpp"
#include "cli/transaction.hpp"
#include "governance/date_time.hpp"

namespace {

using namespace ddssec;

void print(std::FILE* to, const std::string& text) { std::fwrite(text.data(), 1, text.size(), to); }

bool wants_json(const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--format=json") return true;
    if (words[i] == "--format" && i + 1 < words.size() && words[i + 1] == "json") return true;
  }
  return false;
}

Result<WallTime> time_of(const cli::Arguments& arguments) {
  if (!arguments.has("--now")) return SystemClock().now();
  const auto text = arguments.text("--now");
  const auto time = governance::parse_date_time(text, governance::Round::down);
  if (!time)
    return fail(
        Code::usage,
        {.field = "--now", .expected = "a time such as 2026-11-21T00:00:00Z", .found = text});
  return time->time;
}

Result<cli::Report> run(const cli::Request& request) {
  const auto format = request.arguments.text("--format");
  if (format != "text" && format != "json")
    return fail(Code::usage, {.field = "--format", .expected = "text or json", .found = format});
  const ManualClock clock(DDSSEC_TRY(time_of(request.arguments)));
  SystemRandom random;
  return request.command->run(request.arguments, {clock, random});
}

int finish(const cli::Report& report, std::string_view command, bool json) {
  print(stdout, json ? cli::envelope(report, command)
                               .dump(1, ' ', false, cli::Json::error_handler_t::replace) +
                           "\n"
                     : report.text);
  if (!json) print(stderr, cli::diagnostics_text(report));
  const bool flushed = std::fflush(stdout) == 0;
  return static_cast<int>(flushed ? report.exit : cli::Exit::failed);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  cli::note_interruptions();
  const auto request = cli::parse(words);
  if (!request) return finish(cli::report_of(request.error()), "", wants_json(words));
  if (request->command == nullptr) {
    print(stdout, request->help);
    return 0;
  }
  const auto report = run(*request);
  return finish(report ? *report : cli::report_of(report.error()), request->command->full_name(),
                wants_json(words));
}
