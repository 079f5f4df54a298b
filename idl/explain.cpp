// Usage: ddssec-idl-explain [-I FOLDER]... FILE SECONDS IDLC [ARGUMENT]...
//
// Runs idlc on the file for at most SECONDS. idlc reports unsupported constructs only as a "syntax
// error". So if idlc fails, this program searches the file and its includes for what idlc cannot
// read, and prints the position and what to write instead. Exits with 0 if idlc does, otherwise
// with 1. ddssec_idl_generate runs this program.
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct UnknownWord {
  std::string_view word, to_do;
};
// The reserved words of IDL 4.2 that idlc 0.10 does not know. The IDL can use such a word as an
// identifier by writing it as _word.
constexpr std::array kUnknown = {
    UnknownWord{"wstring", "use a string, in UTF-8"},
    UnknownWord{"any", "use a sequence<octet> and a string with the type's name"},
    UnknownWord{"fixed", "use an integer and a scale"},
    UnknownWord{"map", "use a sequence of structs with a key and a value"},
    UnknownWord{"bitset", "use an unsigned integer and constants, or a struct"},
    UnknownWord{"interface", "types of topics are structs: leave it out"},
    UnknownWord{"valuetype", "use a struct"},
    UnknownWord{"exception", "use a struct"},
    UnknownWord{"native", "leave it out"}};

// Iterates over a file's words, without comments and literals.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  // Returns the next word, or an empty text at the end.
  std::string_view next() {
    while (at_ < text_.size()) {
      if (skip_comment() || skip_literal()) continue;
      const auto begin = at_;
      line_of_word_ = line_;
      column_of_word_ = begin - begin_of_line_ + 1;
      while (at_ < text_.size() && is_part(text_[at_])) ++at_;
      if (at_ > begin) return text_.substr(begin, at_ - begin);
      step();
    }
    return {};
  }
  std::size_t line() const { return line_of_word_; }
  std::size_t column() const { return column_of_word_; }

 private:
  static bool is_part(char c) {
    return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0;
  }
  bool starts(std::string_view with) const { return text_.substr(at_).starts_with(with); }
  void step() {
    if (text_[at_] == '\n') ++line_, begin_of_line_ = at_ + 1;
    ++at_;
  }
  bool skip_comment() {
    const std::string_view end = starts("//") ? "\n" : starts("/*") ? "*/" : "";
    if (end.empty()) return false;
    for (at_ += 2; at_ < text_.size() && !starts(end);) step();
    for (std::size_t i = 0; i < end.size() && at_ < text_.size(); ++i) step();
    return true;
  }
  bool skip_literal() {
    const char quote = text_[at_];
    if (quote != '"' && quote != '\'') return false;
    for (++at_; at_ < text_.size() && text_[at_] != quote && text_[at_] != '\n'; step())
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
    if (at_ < text_.size()) step();
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1, begin_of_line_ = 0, line_of_word_ = 1, column_of_word_ = 1;
};

// Returns the name in an include directive, with its quotes or angle brackets; empty if the line
// is not one.
std::string_view included(std::string_view line) {
  const auto skip_blanks = [&] {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  };
  for (const std::string_view part : {"#", "include"}) {
    skip_blanks();
    if (!line.starts_with(part)) return {};
    line.remove_prefix(part.size());
  }
  skip_blanks();
  if (line.empty() || (line[0] != '"' && line[0] != '<')) return {};
  const auto end = line.find(line[0] == '"' ? '"' : '>', 1);
  return end == line.npos ? std::string_view() : line.substr(0, end + 1);
}

// Searches files and the files that they include, each once.
class Explainer {
 public:
  void add_folder(const fs::path& folder) { folders_.push_back(folder); }

  void explain(const fs::path& path) {
    if (seen_.size() >= kMaxFiles || std::ranges::find(seen_, path) != seen_.end()) return;
    seen_.push_back(path);
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    explain_includes(path, text);
    Words words(text);
    for (auto word = words.next(); !word.empty(); word = words.next())
      for (const auto& [unknown, to_do] : kUnknown)
        if (word == unknown)
          std::fprintf(stderr, "%s:%zu:%zu: ddssec cannot do %s: %s\n", path.c_str(), words.line(),
                       words.column(), unknown.data(), to_do.data());
  }

 private:
  static constexpr std::size_t kMaxFiles = 256;

  void explain_includes(const fs::path& path, std::string_view text) {
    for (std::size_t number = 1; !text.empty(); ++number) {
      const auto end = std::min(text.find('\n'), text.size());
      const auto written = included(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (written.size() < 3) continue;  // not an include directive, or one without a name
      const auto name = written.substr(1, written.size() - 2);
      const bool is_quoted = written[0] == '"';
      const auto beside = file_at(path.parent_path() / name);
      const auto found = is_quoted && !beside.empty() ? beside : find(name);
      if (!found.empty())
        explain(found);
      else
        say_missing(path, number, name, !beside.empty());
    }
  }

  // idlc searches the folder of the including file only for names in quotes.
  static void say_missing(const fs::path& path, std::size_t number, std::string_view name,
                          bool is_beside) {
    const std::string file(name);
    std::fprintf(stderr,
                 "%s:%zu: the included file %s is not there: name the folder that holds %s behind "
                 "INCLUDES of ddssec_idl_generate, or with -I of idlc%s\n",
                 path.c_str(), number, file.c_str(), file.c_str(),
                 is_beside ? "; or write it in quotes, since angle brackets do not mean the folder "
                             "of this file"
                           : "");
  }

  // Returns the path, or an empty one if it is not that of a file.
  static fs::path file_at(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored) ? path.lexically_normal() : fs::path();
  }

  // Searches the folders of -I. Returns an empty path if none of them contains the file.
  fs::path find(std::string_view name) const {
    for (const auto& folder : folders_)
      if (auto found = file_at(folder / name); !found.empty()) return found;
    return {};
  }

  std::vector<fs::path> folders_, seen_;
};

enum class RunResult { done, failed, timed_out };

// Runs a command for at most `seconds`. The alarm survives execvp and the end of this process, so
// that idlc does not continue after an interrupted build.
RunResult run(char* const* command, unsigned seconds) {
  const auto child = fork();
  if (child < 0) return RunResult::failed;
  if (child == 0) {
    alarm(seconds);
    execvp(command[0], command);
    std::perror(command[0]);
    _exit(EXIT_FAILURE);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return RunResult::failed;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return RunResult::timed_out;
  return WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS ? RunResult::done
                                                                  : RunResult::failed;
}

}  // namespace

int main(int argc, char** argv) {
  Explainer explainer;
  int at = 1;
  for (; at + 1 < argc && std::string_view(argv[at]) == "-I"; at += 2)
    explainer.add_folder(argv[at + 1]);
  if (argc - at < 3) return EXIT_FAILURE;
  const auto* file = argv[at];
  const auto seconds = static_cast<unsigned>(std::max(1, std::atoi(argv[at + 1])));
  const auto outcome = run(argv + at + 2, seconds);
  if (outcome == RunResult::done) return EXIT_SUCCESS;
  if (outcome == RunResult::timed_out)
    std::fprintf(
        stderr,
        "%s: idlc was stopped after %u s: if it hangs on the last change of the file, write "
        "that differently; if it is slow, give DDSSEC_IDLC_SECONDS (CMake) more\n",
        file, seconds);
  explainer.explain(file);
  return EXIT_FAILURE;
}
