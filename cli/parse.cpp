#include "cli/parse.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <list>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::cli {
namespace {

std::vector<std::string> words_after(std::string_view group) {
  std::vector<std::string> out;
  for (const auto& command : commands()) {
    if (group.empty()) out.emplace_back(command.group.empty() ? command.name : command.group);
    if (!group.empty() && command.group == group) out.emplace_back(command.name);
  }
  return out;
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  const std::size_t near = word.size() < 7 ? 1 : 2;  // "--foo" is not meant as "--now"
  const auto best = std::ranges::min_element(
      known, {}, [&](const std::string& k) { return edit_distance(word, k); });
  return best != known.end() && edit_distance(word, *best) <= near ? *best : std::string();
}

std::unexpected<Error> wrong(std::string note) {
  return fail(Code::usage, {.note = std::move(note)});
}

std::unexpected<Error> unknown(std::string_view word, const std::vector<std::string>& known) {
  const auto guess = nearest(word.substr(0, 64), known);
  return wrong("\"" + std::string(word) + "\" is unknown here" +
               (guess.empty() ? "" : "; did you mean \"" + guess + "\"?"));
}

// CLI11 reads one command's arguments; which command it is was told before.
class CommandLine {
 public:
  explicit CommandLine(const Command& command) {
    app_.set_help_flag();
    app_.allow_extras(false);
    for (const auto& option : command.options) add(option);
    for (const auto& option : common_options()) add(option);
    for (const auto& positional : command.positionals) add(positional);
  }

  Result<Arguments> parse(std::span<const std::string> words) {
    DDSSEC_TRY(check_values(words));
    std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 takes them
    try {
      app_.parse(std::move(reversed));
    } catch (const CLI::ParseError& error) {
      return explained(error, words);
    }
    return Arguments(values());
  }

 private:
  struct Slot {
    std::string name;
    std::string_view fallback;
    std::vector<std::string> values;
    CLI::Option* option;
  };

  void add(const Option& option) {
    auto& slot = slots_.emplace_back(std::string(option.name), option.fallback);
    if (option.value.empty()) {
      slot.option = app_.add_flag(option.spellings());
      return;
    }
    slot.option = app_.add_option(option.spellings(), slot.values)->allow_extra_args(false);
    if (!option.repeated) slot.option->expected(1);
    slot.option->required(option.required);
  }

  void add(const Positional& positional) {
    auto& slot = slots_.emplace_back(std::string(positional.name));
    slot.option = app_.add_option(slot.name, slot.values)->required(!positional.optional);
    if (!positional.repeated) slot.option->expected(1)->allow_extra_args(false);
  }

  // CLI11 takes the next word where nothing is behind the equals sign: that would be another
  // option's name or a file.
  Status check_values(std::span<const std::string> words) const {
    for (const auto& word : words) {
      const std::string_view name = std::string_view(word).substr(0, word.find('='));
      const bool ends_there = name.starts_with("--") && name.size() + 1 == word.size();
      if (ends_there && std::ranges::find(slots_, name, &Slot::name) != slots_.end())
        return wrong(
            fmt::format("nothing follows \"{}\"; an empty value is written {} ''", word, name));
    }
    return {};
  }

  // CLI11 does not say which option is unknown, only that there are too many words.
  std::unexpected<Error> explained(const CLI::ParseError& error,
                                   std::span<const std::string> words) const {
    std::vector<std::string> known;
    for (const auto& slot : slots_) known.push_back(slot.name);
    for (const auto& option : common_options())
      if (!option.letter.empty()) known.emplace_back(option.letter);
    for (const auto& word : words) {
      const auto name = word.substr(0, word.find('='));
      if (name.starts_with("-") && name != "-" && std::ranges::find(known, name) == known.end())
        return unknown(name, known);
    }
    const std::string what = error.what();
    constexpr std::string_view kRequired = " is required";
    if (what.ends_with(kRequired))
      return wrong("missing argument " + what.substr(0, what.size() - kRequired.size()));
    return wrong(what);
  }

  Arguments::Values values() const {
    Arguments::Values out;
    for (const auto& slot : slots_) {
      if (slot.option->count() > 0) {
        out[slot.name] = slot.values;
      } else if (!slot.fallback.empty()) {
        out[slot.name] = {std::string(slot.fallback)};
      }
    }
    return out;
  }

  CLI::App app_;
  std::list<Slot> slots_;  // CLI11 keeps references into it
};

// Options of every command may stand before it as well: from there they are put behind it.
std::vector<std::string> command_first(std::span<const std::string> words) {
  std::vector<std::string> options;
  std::size_t at = 0;
  while (at < words.size()) {
    const auto& word = words[at];
    const auto name = word.substr(0, word.find('='));
    const auto option = std::ranges::find_if(common_options(), [&](const Option& o) {
      return o.name == name || (!o.letter.empty() && o.letter == word);
    });
    if (option == common_options().end()) break;
    const bool takes_next = !option->value.empty() && name.size() == word.size();
    for (std::size_t i = 0; i <= (takes_next ? 1 : 0) && at < words.size(); ++i)
      options.push_back(words[at++]);
  }
  std::vector<std::string> out(words.begin() + static_cast<std::ptrdiff_t>(at), words.end());
  if (!out.empty() && (out[0] == "--version" || out[0] == "-V")) out[0] = "version";
  out.insert(out.end(), options.begin(), options.end());
  return out;
}

bool asks_for_help(std::span<const std::string> words) {
  return std::ranges::any_of(words, [](const auto& w) { return w == "--help" || w == "-h"; });
}

const Command* find(std::string_view full_name) {
  const auto found = std::ranges::find_if(
      commands(), [&](const Command& c) { return c.full_name() == full_name; });
  return found == commands().end() ? nullptr : &*found;
}

Request help_request(std::string_view what) {
  Request out;
  out.help = help_on(what);
  return out;
}

}  // namespace

std::string command_named(std::span<const std::string> given) {
  const auto words = command_first(given);
  if (words.size() > 1 && find(words[0] + " " + words[1]) != nullptr)
    return words[0] + " " + words[1];
  return words.empty() || help_on(words[0]).empty() ? std::string() : words[0];
}

Result<Request> parse(std::span<const std::string> given) {
  auto words = command_first(given);
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  if (words.empty() || words[0].starts_with("-"))
    return asks_for_help(words) ? Result<Request>(help_request("")) : wrong("no command is given");
  const Command* command = find(words[0]);
  std::size_t used = 1;
  if (command == nullptr) {
    if (help_on(words[0]).empty()) return unknown(words[0], words_after(""));
    if (words.size() > 1 && (command = find(words[0] + " " + words[1])) != nullptr) used = 2;
  }
  if (asks_for_help(words)) return help_request(command ? command->full_name() : words[0]);
  if (command == nullptr)
    return words.size() > 1 && !words[1].starts_with("-")
               ? unknown(words[1], words_after(words[0]))
               : wrong("\"" + words[0] + "\" needs a second word");
  CommandLine line(*command);
  Request out;
  out.arguments = DDSSEC_TRY(line.parse(std::span(words).subspan(used)));
  out.command = command;
  return out;
}

}  // namespace ddssec::cli
