// completion, man: generates completions for shells and the man page from the table of commands.
#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/groups.hpp"
#include "cli/frame/choices.hpp"

namespace ddssec::cli {
namespace {

std::string replaced(std::string_view text, char from, std::string_view to) {
  std::string out;
  for (const char c : text) {
    if (c == from)
      out += to;
    else
      out += c;
  }
  return out;
}

void add_word(std::string& list, std::string_view word, std::string_view between = " ") {
  if (!list.empty()) list += between;
  list += word;
}

// Quotes a text for a shell, in single quotes.
std::string single_quoted(std::string_view text) {
  return '\'' + replaced(text, '\'', "'\\''") + '\'';
}

std::vector<Option> options_of(const Command& command) {
  auto out = command.options;
  const auto& common = common_options();
  out.insert(out.end(), common.begin(), common.end());
  out.push_back({.name = "--help", .value = "", .summary = "help on the command", .letter = "-h"});
  return out;
}

// A first word of the command line: a group, or a command of one word.
struct FirstWord {
  std::string_view word;
  std::string summary;
  std::vector<const Command*> commands;  // the commands of the group
};

std::vector<FirstWord> first_words() {
  std::vector<FirstWord> out;
  for (const auto& command : commands()) {
    if (command.group.empty()) {
      out.push_back({command.name, std::string(command.summary), {}});
      continue;
    }
    auto group = std::ranges::find(out, command.group, &FirstWord::word);
    if (group == out.end()) group = out.insert(out.end(), {command.group, {}, {}});
    group->commands.push_back(&command);
    add_word(group->summary, command.name, ", ");
  }
  return out;
}

std::string spelled(const std::vector<Option>& options) {
  std::string out;
  for (const auto& option : options) add_word(out, replaced(option.spellings(), ',', " "));
  return out;
}

// A place where one of a few words is expected.
struct Place {
  std::string pattern;  // the pattern of a shell's `case`: "WORDS OPTION", or "NUMBER COMMAND"
  std::string words;
};

// The values of options. For a command of one word, the second word of the line may be anything.
std::vector<Place> values_of_options() {
  std::vector<Place> out;
  for (const auto& command : commands()) {
    const auto name = command.full_name();
    for (const auto& option : options_of(command))
      if (auto words = choices_of(command, option.name); !words.empty())
        out.push_back({command.group.empty() ? fmt::format("'{} '*' {}'", name, option.name)
                                             : fmt::format("'{} {}'", name, option.name),
                       std::move(words)});
  }
  return out;
}

// The positions after commands of one word, counted from the program's name at 0.
std::vector<Place> values_of_places() {
  std::vector<Place> out;
  for (const auto& command : commands())
    for (std::size_t i = 0; i < command.positionals.size(); ++i)
      if (auto words = choices_of(command, command.positionals[i].name);
          !words.empty() && command.group.empty())
        out.push_back({fmt::format("'{} {}'", i + 2, command.name), std::move(words)});
  return out;
}

// Returns a case arm for each place. `before` and `after` turn the words into the shell's form.
std::string cases(const std::vector<Place>& places, std::string_view before,
                  std::string_view after) {
  std::string out;
  for (const auto& [pattern, words] : places)
    out += fmt::format("      {}) {}{}{} ;;\n", pattern, before, words, after);
  return out;
}

std::string bash() {
  std::string firsts, seconds, options;
  for (const auto& first : first_words()) {
    add_word(firsts, first.word);
    if (first.commands.empty()) continue;
    std::string names;
    for (const auto* command : first.commands) add_word(names, command->name);
    seconds += fmt::format("      {}) words={} ;;\n", first.word, single_quoted(names));
  }
  for (const auto& command : commands())
    options += fmt::format("      {}) words={} ;;\n",
                           command.group.empty() ? single_quoted(command.full_name()) + "*"
                                                 : single_quoted(command.full_name()),
                           single_quoted(spelled(options_of(command))));
  return fmt::format(
      "# bash completion of ddssec: ddssec completion bash > "
      "~/.local/share/bash-completion/completions/ddssec\n"
      "_ddssec() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words=''\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    words={}\n"
      "  elif [[ $current == -* ]]; then\n"
      "    case \"${{COMP_WORDS[1]}} ${{COMP_WORDS[2]}}\" in\n{}    esac\n"
      "  elif [ \"$COMP_CWORD\" -eq 2 ]; then\n"
      "    case \"${{COMP_WORDS[1]}}\" in\n{}    esac\n"
      "  fi\n"
      "  if [[ -z $words && $current != -* ]]; then\n"
      "    case \"${{COMP_WORDS[1]}} ${{COMP_WORDS[2]}} $before\" in\n{}    esac\n"
      "  fi\n"
      "  if [[ -z $words && $current != -* ]]; then\n"
      "    case \"$COMP_CWORD ${{COMP_WORDS[1]}}\" in\n{}    esac\n"
      "  fi\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "}}\n"
      "complete -o default -F _ddssec ddssec\n",
      single_quoted(firsts), options, seconds, cases(values_of_options(), "words='", "'"),
      cases(values_of_places(), "words='", "'"));
}

// One entry of _describe: a colon separates the word from its description.
std::string zsh_entry(std::string_view word, std::string_view summary) {
  return single_quoted(fmt::format("{}:{}", word, replaced(summary, ':', "\\:")));
}

std::string zsh() {
  std::string firsts, seconds, options;
  for (const auto& first : first_words()) {
    firsts += fmt::format("    {}\n", zsh_entry(first.word, first.summary));
    if (first.commands.empty()) continue;
    std::string entries;
    for (const auto* command : first.commands)
      entries += fmt::format(" {}", zsh_entry(command->name, command->summary));
    seconds += fmt::format("      {}) list=({} ) ;;\n", first.word, entries);
  }
  for (const auto& command : commands()) {
    std::string entries;
    for (const auto& option : options_of(command)) {
      entries += fmt::format(" {}", zsh_entry(option.name, option.summary));
      if (!option.letter.empty())
        entries += fmt::format(" {}", zsh_entry(option.letter, option.summary));
    }
    options += fmt::format("      {}) list=({} ) ;;\n",
                           command.group.empty() ? single_quoted(command.full_name()) + "*"
                                                 : single_quoted(command.full_name()),
                           entries);
  }
  return fmt::format(
      "#compdef ddssec\n"
      "# zsh completion of ddssec: ddssec completion zsh > a folder of $fpath/_ddssec\n"
      "_ddssec() {{\n"
      "  local -a list\n"
      "  if (( CURRENT == 2 )); then\n"
      "    list=(\n{}    )\n"
      "  elif [[ $words[CURRENT] == -* ]]; then\n"
      "    case \"$words[2] $words[3]\" in\n{}    esac\n"
      "  elif (( CURRENT == 3 )); then\n"
      "    case \"$words[2]\" in\n{}    esac\n"
      "  fi\n"
      "  if (( ! $#list )) && [[ $words[CURRENT] != -* ]]; then\n"
      "    case \"$words[2] $words[3] $words[CURRENT-1]\" in\n{}    esac\n"
      "  fi\n"
      "  if (( ! $#list )) && [[ $words[CURRENT] != -* ]]; then\n"
      "    case \"$((CURRENT - 1)) $words[2]\" in\n{}    esac\n"
      "  fi\n"
      "  if (( $#list )); then _describe ddssec list; else _files; fi\n"
      "}}\n"
      "compdef _ddssec ddssec\n",
      firsts, options, seconds, cases(values_of_options(), "list=(", ")"),
      cases(values_of_places(), "list=(", ")"));
}

std::string fish_condition(const Command& command) {
  return command.group.empty()
             ? fmt::format("__fish_seen_subcommand_from {}", command.name)
             : fmt::format("__fish_seen_subcommand_from {}; and __fish_seen_subcommand_from {}",
                           command.group, command.name);
}

std::string fish_option(const Command& command, const Option& option) {
  const bool is_short = !option.name.starts_with("--");  // a name such as -o
  auto out = fmt::format("complete -c ddssec -n {}", single_quoted(fish_condition(command)));
  out += is_short ? fmt::format(" -s {}", option.name.substr(1))
                  : fmt::format(" -l {}", option.name.substr(2));
  if (!option.letter.empty()) out += fmt::format(" -s {}", option.letter.substr(1));
  if (!option.value.empty()) out += " -r";
  if (const auto words = choices_of(command, option.name); !words.empty())
    out += fmt::format(" -f -a {}", single_quoted(words));
  return out + fmt::format(" -d {}\n", single_quoted(option.summary));
}

std::string fish() {
  std::string out =
      "# fish completion of ddssec: ddssec completion fish > "
      "~/.config/fish/completions/ddssec.fish\n";
  for (const auto& first : first_words()) {
    out += fmt::format("complete -c ddssec -f -n __fish_use_subcommand -a {} -d {}\n", first.word,
                       single_quoted(first.summary));
    std::string names;
    for (const auto* command : first.commands) names += fmt::format(" {}", command->name);
    for (const auto* command : first.commands)
      out += fmt::format("complete -c ddssec -f -n {} -a {} -d {}\n",
                         single_quoted(fmt::format("__fish_seen_subcommand_from {}; and not "
                                                   "__fish_seen_subcommand_from{}",
                                                   first.word, names)),
                         command->name, single_quoted(command->summary));
  }
  for (const auto& command : commands())
    for (const auto& option : options_of(command)) out += fish_option(command, option);
  for (const auto& command : commands())
    for (const auto& positional : command.positionals)
      if (const auto words = choices_of(command, positional.name); !words.empty())
        out += fmt::format("complete -c ddssec -f -n {} -a {}\n",
                           single_quoted(fish_condition(command)), single_quoted(words));
  return out;
}

// Escapes text for roff: a leading dot or quote, and every backslash and minus.
std::string roff(std::string_view text) {
  auto out = replaced(replaced(text, '\\', "\\e"), '-', "\\-");
  return out.starts_with('.') || out.starts_with('\'') ? fmt::format("\\&{}", out) : out;
}

std::string man_option(const Option& option) {
  std::string notes;
  if (option.required) notes += " Required.";
  if (option.repeated) notes += " May be repeated.";
  if (!option.fallback.empty()) notes += fmt::format(" Default: {}.", option.fallback);
  return fmt::format(".TP\n\\fB{}\\fR{}\n{}.{}\n", roff(replaced(option.spellings(), ',', ", ")),
                     option.value.empty() ? "" : fmt::format(" \\fI{}\\fR", roff(option.value)),
                     roff(option.summary), roff(notes));
}

std::string man_command(const Command& command) {
  std::string out = fmt::format(".SS ddssec {}", roff(command.full_name()));
  for (const auto& positional : command.positionals) {
    const auto name = roff(positional.name) + (positional.repeated ? "..." : "");
    out += positional.optional ? fmt::format(" [{}]", name) : fmt::format(" {}", name);
  }
  out += fmt::format(" [OPTIONS]\n{}\n", roff(command.summary));
  for (const auto& positional : command.positionals)
    out += fmt::format(".TP\n\\fI{}\\fR\n{}.\n", roff(positional.name), roff(positional.summary));
  for (const auto& option : command.options) out += man_option(option);
  out += ".PP\n";
  for (const auto& example : command.examples)
    out += fmt::format(".nf\n\\&    {}\n.fi\n", roff(example));
  return out;
}

std::string man_page() {
  std::string out =
      ".TH DDSSEC 1 \"\" \"ddssec\" \"User Commands\"\n"
      ".SH NAME\nddssec \\- certificates, governance and permissions of DDS\\-Security\n"
      ".SH SYNOPSIS\n\\fBddssec\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n"
      ".SH OPTIONS OF EVERY COMMAND\n";
  for (const auto& option : common_options()) out += man_option(option);
  out += ".SH COMMANDS\n";
  for (const auto& command : commands()) out += man_command(command);
  return out +
         ".SH EXIT STATUS\n0 done or yes, 1 no, 2 wrong command line, 3 unreadable input, 4 "
         "refused "
         "for safety, 5 failed.\n"
         ".SH ENVIRONMENT\n.TP\n\\fBNO_COLOR\\fR\nIf it is not empty: no colour, unless "
         "\\-\\-color says so.\n";
}

struct PrintedText {
  static constexpr std::string_view kDef = "printed";
  std::string form, page;

  static constexpr auto fields() {
    return std::tuple(field<&PrintedText::form>({.words = "bash|zsh|fish|man"}),
                      field("text", &PrintedText::page));
  }
  const std::string& text() const { return page; }
};

Result<Answer<PrintedText>> completion(const Arguments& arguments, const Context&) {
  const auto shell = arguments.text("SHELL");
  if (shell == "bash") return Answer<PrintedText>{{shell, bash()}};
  if (shell == "zsh") return Answer<PrintedText>{{shell, zsh()}};
  if (shell == "fish") return Answer<PrintedText>{{shell, fish()}};
  return fail(Code::usage, {.field = "SHELL", .expected = "bash, zsh or fish", .found = shell});
}

Result<Answer<PrintedText>> man(const Arguments&, const Context&) {
  return Answer<PrintedText>{{"man", man_page()}};
}

}  // namespace

std::vector<Command> completion_commands() {
  return {
      {.group = "",
       .name = "completion",
       .summary = "Prints what a shell must read to complete commands and options.",
       .positionals = {{"SHELL", "bash, zsh or fish"}},
       .options = {},
       .examples = {"ddssec completion bash > ~/.local/share/bash-completion/completions/ddssec"},
       .run = completion},
      {.group = "",
       .name = "man",
       .summary = "Prints the manual page.",
       .positionals = {},
       .options = {},
       .examples = {"ddssec man > ddssec.1"},
       .run = man}};
}

}  // namespace ddssec::cli
