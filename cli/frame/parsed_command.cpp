#include "cli/frame/parsed_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <list>
#include <ranges>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/frame/choices.hpp"
#include "cli/frame/suggestions.hpp"

namespace ddssec::cli {
namespace {

std::unexpected<Error> wrong_usage_error(std::string note) {
  return fail(Code::usage, {.note = std::move(note)});
}

std::unexpected<Error> unknown_word_error(std::string_view word,
                                          const std::vector<std::string>& guesses) {
  return wrong_usage_error("\"" + std::string(word) + "\" is unknown here" + did_you_mean(guesses));
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i)
    out += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return out;
}

// Parses the arguments of one command with CLI11. The command itself was determined before.
class CommandLine {
 public:
  explicit CommandLine(const Command& command) : command_(command) {
    app_.set_help_flag();
    app_.allow_extras(false);
    for (const auto& option : command.options) add(option);
    for (const auto& option : common_options()) add(option);
    for (const auto& positional : command.positionals) add(positional);
  }

  Result<Arguments> parse(std::span<const std::string> words) {
    DDSSEC_RETURN_IF_ERROR(check_values(words));
    DDSSEC_RETURN_IF_ERROR(check_names(words));
    std::vector<std::string> reversed(words.rbegin(), words.rend());  // the order of CLI11
    try {
      app_.parse(std::move(reversed));
    } catch (const CLI::ParseError& error) {
      return parse_error(error);
    }
    return Arguments(values());
  }

 private:
  struct Slot {
    std::string name;
    std::string_view fallback;
    std::vector<std::string> values;
    CLI::Option* option;
    bool required = false;
    std::string_view unless = {};
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
    slot.required = option.required;
  }

  void add(const Positional& positional) {
    auto& slot = slots_.emplace_back(std::string(positional.name));
    slot.option = app_.add_option(slot.name, slot.values)->required(!positional.optional);
    if (!positional.repeated) slot.option->expected(1)->allow_extra_args(false);
    slot.required = !positional.optional;
    slot.unless = positional.unless;
  }

  // If nothing follows the equals sign, CLI11 takes the next word, which may be the name of another
  // option or a file.
  Status check_values(std::span<const std::string> words) const {
    for (const auto& word : words) {
      const std::string_view name = std::string_view(word).substr(0, word.find('='));
      const bool ends_there = name.starts_with("--") && name.size() + 1 == word.size();
      if (ends_there && std::ranges::find(slots_, name, &Slot::name) != slots_.end())
        return wrong_usage_error(
            fmt::format("nothing follows \"{}\"; an empty value is written {} ''", word, name));
    }
    return {};
  }

  const Option* option_named(std::string_view name) const {
    for (const auto* options : {&command_.options, &common_options()})
      for (const auto& option : *options)
        if (option.name == name || (!option.letter.empty() && option.letter == name))
          return &option;
    return nullptr;
  }

  // CLI11 reads an option's name as the value of the option before it. It also does not report
  // which option is unknown, only that there are too many words.
  Status check_names(std::span<const std::string> words) const {
    const Option* waits = nullptr;  // the option that still needs its value
    for (const auto& word : words) {
      auto name = std::string_view(word).substr(0, word.find('='));
      if (word == "--" && waits == nullptr) return {};
      const bool looks_like_one = name.starts_with("-") && name != "-";
      const bool has_letter = looks_like_one && name[1] != '-' && option_named(name.substr(0, 2));
      if (has_letter) name = name.substr(0, 2);  // "-oFILE"
      const auto* option = looks_like_one ? option_named(name) : nullptr;
      if (waits != nullptr && option != nullptr)
        return wrong_usage_error(
            fmt::format("no value follows \"{0}\": \"{1}\" is an option; if it is meant as "
                        "the value, write {0}={1}",
                        waits->name, word));
      const bool is_value = waits != nullptr;
      waits = nullptr;
      if (is_value || !looks_like_one) continue;
      if (option == nullptr) return unknown_word_error(name, options_like(name, command_));
      if (!option->value.empty() && name.size() == word.size()) waits = option;
    }
    if (waits != nullptr)
      return wrong_usage_error(fmt::format("no value follows \"{}\"", waits->name));
    return {};
  }

  // Returns the positional that the user probably left out. If only the last positional is missing
  // and the word before it is not one of its choices, the user left out the one before.
  std::string left_out(const std::string& lacking) const {
    const auto& positionals = command_.positionals;
    if (positionals.size() < 2 || lacking != positionals.back().name) return lacking;
    const auto before = std::string(positionals[positionals.size() - 2].name);
    const auto slot = std::ranges::find(slots_, before, &Slot::name);
    const auto words = choices_of(command_, before);
    if (words.empty() || slot->values.empty()) return lacking;
    const bool is_choice = (" " + words + " ").contains(" " + ascii_lower(slot->values[0]) + " ");
    return is_choice ? lacking : before;
  }

  // Everything that is required but was not given, in one sentence.
  std::vector<std::string> missing() const {
    std::vector<std::string> out;
    for (const auto& slot : slots_) {
      if (slot.option->count() > 0) continue;
      if (slot.required) out.push_back(option_with_value(slot.name));
      if (!slot.unless.empty() && !is_given(slot.unless))
        out.push_back(fmt::format("{} (or {})", slot.name, option_with_value(slot.unless)));
    }
    if (out.size() == 1) out[0] = left_out(out[0]);
    return out;
  }
  // An option together with its value.
  std::string option_with_value(std::string_view name) const {
    const auto* option = option_named(name);
    return option == nullptr ? std::string(name)
                             : fmt::format("{} {}", option->name, option->value);
  }
  bool is_given(std::string_view name) const {
    const auto slot = std::ranges::find(slots_, name, &Slot::name);
    return slot != slots_.end() && slot->option->count() > 0;
  }

  std::unexpected<Error> parse_error(const CLI::ParseError& error) const {
    const auto lacking = missing();
    const auto rest = app_.remaining();
    std::string extra;
    for (const auto& word : rest)
      extra += fmt::format("{}\"{}\"", extra.empty() ? "" : ", ", word.substr(0, 64));
    if (!extra.empty())
      extra += rest.size() == 1 ? " is one argument too many" : " are arguments too many";
    if (rest.size() == 1 && !command_.instead_of_extra.empty())
      extra += fmt::format("; {}", command_.instead_of_extra);
    if (lacking.empty())
      return wrong_usage_error(extra.empty() ? std::string(error.what()) : extra);
    return wrong_usage_error(
        fmt::format("missing argument{} {}{}{}; for example: {}", lacking.size() == 1 ? "" : "s",
                    listed(lacking), extra.empty() ? "" : "; ", extra, command_.examples.front()));
  }

  // The words of a table are accepted in any letter case, also before the version of a product.
  std::vector<std::string> as_chosen(const Slot& slot) const {
    auto out = slot.values;
    const auto words = choices_of(command_, slot.name);
    for (auto& value : out) {
      const auto end = std::min(value.find('@'), value.size());
      for (const auto word : std::views::split(words, ' '))
        if (ascii_lower(std::string_view(word)) == ascii_lower(value.substr(0, end)))
          value.replace(0, end, std::string_view(word));
    }
    return out;
  }

  Arguments::Values values() const {
    Arguments::Values out;
    for (const auto& slot : slots_) {
      if (slot.option->count() > 0) {
        out[slot.name] = as_chosen(slot);
      } else if (!slot.fallback.empty()) {
        out[slot.name] = {std::string(slot.fallback)};
      }
    }
    return out;
  }

  const Command& command_;
  CLI::App app_;
  std::list<Slot> slots_;  // CLI11 keeps references to its elements
};

// Options that every command accepts may stand before the command: they are moved behind it.
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

// For example "create, import, show or renew".
std::string second_words(std::string_view group) {
  std::string out;
  for (const auto& command : commands())
    if (command.group == group) out += fmt::format("{}{}", out.empty() ? "" : ", ", command.name);
  return out;
}

ParsedCommand help_request(std::string_view what) {
  ParsedCommand out;
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

Result<ParsedCommand> parse(std::span<const std::string> given) {
  auto words = command_first(given);
  if (!words.empty() && words[0] == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  if (words.empty() || words[0].starts_with("-"))
    return asks_for_help(words) ? Result<ParsedCommand>(help_request(""))
                                : wrong_usage_error("no command is given");
  const Command* command = find(words[0]);
  std::size_t used = 1;
  if (command == nullptr) {
    if (help_on(words[0]).empty()) return unknown_word_error(words[0], commands_like(words));
    if (words.size() > 1 && (command = find(words[0] + " " + words[1])) != nullptr) used = 2;
  }
  if (asks_for_help(words)) return help_request(command ? command->full_name() : words[0]);
  if (command == nullptr)
    return words.size() > 1 && !words[1].starts_with("-")
               ? unknown_word_error(words[1], commands_like(words))
               : wrong_usage_error("\"" + words[0] +
                                   "\" needs a second word: " + second_words(words[0]));
  CommandLine line(*command);
  ParsedCommand out;
  DDSSEC_ASSIGN_OR_RETURN(out.arguments, line.parse(std::span(words).subspan(used)));
  out.command = command;
  return out;
}

}  // namespace ddssec::cli
