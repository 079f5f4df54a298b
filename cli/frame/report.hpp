// The report of a command: one value that prints as text or as the JSON envelope.
#pragma once

#include <string>
#include <vector>

#include "base/finding.hpp"
#include "base/result.hpp"
#include "cli/frame/fields.hpp"

namespace ddssec::cli {

/// The exit codes of every command.
enum class Exit : std::uint8_t {
  done = 0,        ///< done, or the answer is yes
  no = 1,          ///< the answer is no
  usage = 2,       ///< the command line is wrong
  unreadable = 3,  ///< an input cannot be read or parsed
  refused = 4,     ///< refused for safety
  failed = 5,      ///< an internal failure, or the result could not be written
};

/// Returns the exit code of a command that ends with this error.
Exit exit_of(Code code);

/// A file that the command made.
struct WrittenFile {
  std::string path;
  std::string mode;  ///< octal, such as "0600"; "link" for a symbolic link
  /// Lower-case hexadecimal. Empty if the file was not written (--dry-run) and is not predicted.
  std::string sha256 = {};
  std::string link_to = {};  ///< the target of a symbolic link
};

/// The result of a command.
struct Report {
  Exit exit = Exit::done;
  std::string text;  ///< for people; complete lines
  Json result = Json::object();
  std::vector<Error> errors = {};
  std::vector<Finding> findings = {};  ///< from lint and doctor
  std::vector<WrittenFile> files_written = {};
  std::string help_on = {};   ///< the command or group of the command line, for the hint of `usage`
  std::string forecast = {};  ///< for people, with --dry-run: what would follow
};

/// Returns the word in diagnostics: "error", "warning" or "note".
std::string_view severity_word(Severity severity);

/// Returns the report of a command that failed.
Report report_of(const Error& error);

/// Returns one object with the same members for every command and for failures: schema, command,
/// ok, exit, result, diagnostics, files_written.
Json envelope(const Report& report, std::string_view command);

/// The parts of a report that go to standard error, and their style.
struct Style {
  bool color = false;
  bool quiet = false;    ///< errors only
  bool verbose = false;  ///< every file as well
};

/// Returns every error and finding as text for people: "error[CODE]: what happened"; "  -->
/// file:line" if there is a place; "  hint: what to do".
std::string diagnostics_text(const Report& report, Style style = {});

/// Returns what to do about an error, in the words of the command line, because some hints of the
/// library mention a participant's properties. `help_on` is Report::help_on.
std::string hint_of(const Error& error, const std::string& help_on = {});

/// Returns a text such as "1 folder" or "3 folders".
std::string count_text(std::size_t count, std::string_view thing);

/// Returns a text such as "would write 0600 path" for every file: the output of --dry-run.
std::string dry_run_text(const Report& report);

}  // namespace ddssec::cli
