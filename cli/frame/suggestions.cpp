#include "cli/frame/suggestions.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::cli {
namespace {

constexpr std::size_t kMaxGuesses = 4;
constexpr std::size_t kMaxOctets = 64;  // of a word that is compared

// Verbs of other tools, with the corresponding verbs of this tool. The first one that the group has
// is suggested.
struct Verb {
  std::string_view typed;
  std::array<std::string_view, 4> meant;
};
constexpr Verb kVerbs[] = {
    {"new", {"create", "issue", "enclave"}},
    {"create", {"new", "issue", "enclave"}},
    {"init", {"create", "new", "issue"}},
    {"make", {"create", "new", "issue"}},
    {"generate", {"new", "create", "issue"}},
    {"gen", {"new", "create", "issue"}},
    {"add", {"issue", "enclave", "new"}},
    {"request", {"csr"}},
    {"delete", {"revoke"}},
    {"remove", {"revoke"}},
    {"print", {"show", "list"}},
    {"view", {"show"}},
    {"info", {"show"}},
    {"cat", {"show"}},
    {"list", {"show"}},
    {"inspect", {"show"}},
    {"validate", {"verify", "lint"}},
    {"check", {"verify", "lint"}},
    {"compare", {"diff"}},
    {"update", {"renew", "distribute"}},
    {"publish", {"distribute"}},
    {"copy", {"distribute"}},
};

// Options of other tools.
struct Spelling {
  std::string_view typed;
  std::array<std::string_view, 3> meant;
};
constexpr Spelling kSpellings[] = {
    {"--json", {"--format json"}},
    {"--out", {"-o"}},
    {"--output", {"-o"}},
    {"--dir", {"-o"}},
    {"--force", {"--replace"}},
    {"--overwrite", {"--replace"}},
    {"--topic", {"--topics", "--publish", "--subscribe"}},
    {"--topics", {"--topic", "--publish", "--subscribe"}},
    {"--password", {"--passphrase-file", "--passphrase-env"}},
    {"--passphrase", {"--passphrase-file", "--passphrase-env"}},
    {"--expires", {"--days", "--not-after"}},
    {"--validity", {"--days"}},
    {"--cn", {"--subject"}},
    {"--subject", {"--cert"}},
    {"--name", {"--participant", "--subject", "--cert"}},
    {"--time", {"--now"}},
    {"--date", {"--now"}},
};

const Command* command_of(std::string_view group, std::string_view name) {
  const auto found = std::ranges::find_if(
      commands(), [&](const Command& c) { return c.group == group && c.name == name; });
  return found == commands().end() ? nullptr : &*found;
}

void add(std::vector<std::string>& out, std::string word) {
  const bool is_new = !word.empty() && std::ranges::find(out, word) == out.end();
  if (is_new && out.size() < kMaxGuesses) out.push_back(std::move(word));
}

bool has_group(std::string_view group) {
  return std::ranges::find(commands(), group, &Command::group) != commands().end();
}

bool is_sought_in(const Command& command, std::string_view group) {
  return std::ranges::find(command.sought_in, group) != command.sought_in.end();
}

// The group's command with this name, or with a verb of the same meaning. nullptr if there is none.
const Command* in_group(std::string_view group, std::string_view verb) {
  if (const auto* command = command_of(group, verb)) return command;
  for (const auto& row : kVerbs)
    if (row.typed == verb)
      for (const auto meant : row.meant)
        if (const auto* command = command_of(group, meant)) return command;
  return nullptr;
}

std::vector<std::string> names_in(std::string_view group) {
  std::vector<std::string> out;
  for (const auto& command : commands()) {
    if (group.empty()) out.emplace_back(command.group.empty() ? command.name : command.group);
    if (!group.empty() && command.group == group) out.emplace_back(command.name);
  }
  return out;
}

void add_second_words(std::vector<std::string>& out, std::string_view group,
                      std::string_view word) {
  for (const auto& command : commands())
    if (command.name == word && is_sought_in(command, group)) return add(out, command.full_name());
  const auto* command = in_group(group, word);
  add(out, command != nullptr ? std::string(command->name) : nearest(word, names_in(group)));
}

bool takes(const Command& command, std::string_view option) {
  const auto name = option.substr(0, option.find(' '));
  const auto is_it = [&](const Option& o) { return o.name == name; };
  return std::ranges::any_of(command.options, is_it) ||
         std::ranges::any_of(common_options(), is_it);
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  word = word.substr(0, kMaxOctets);
  const std::size_t near = word.size() < 7 ? 1 : 2;  // "--foo" is not meant as "--now"
  const auto best = std::ranges::min_element(
      known, {}, [&](const std::string& k) { return edit_distance(word, k); });
  return best != known.end() && edit_distance(word, *best) <= near ? *best : std::string();
}

std::vector<std::string> commands_like(std::span<const std::string> words) {
  std::vector<std::string> out;
  if (words.empty()) return out;
  const auto first = std::string_view(words[0]).substr(0, kMaxOctets);
  const auto second = words.size() > 1 ? std::string_view(words[1]).substr(0, kMaxOctets) : "";
  if (has_group(first)) {
    if (!second.empty()) add_second_words(out, first, second);
    return out;
  }
  if (const auto* swapped = has_group(second) ? in_group(second, first) : nullptr)
    return {swapped->full_name()};
  add(out, nearest(first, names_in("")));
  for (const auto& command : commands())
    if (!command.group.empty() && command.name == first) add(out, command.full_name());
  if (!out.empty()) return out;
  for (const auto& row : kVerbs)
    if (row.typed == first)
      for (const auto& command : commands())
        if (std::ranges::find(row.meant, command.name) != row.meant.end())
          add(out, command.full_name());
  return out;
}

std::vector<std::string> options_like(std::string_view word, const Command& command) {
  std::vector<std::string> out;
  std::vector<std::string> known;
  for (const auto* options : {&command.options, &common_options()})
    for (const auto& option : *options) {
      known.emplace_back(option.name);
      // A single letter means an option that begins with it.
      if (word.size() == 2 && option.name.starts_with(fmt::format("-{}", word)))
        add(out, std::string(option.name));
    }
  if (word.size() == 2) return out;
  for (const auto& row : kSpellings)
    if (row.typed == word)
      for (const auto meant : row.meant)
        if (!meant.empty() && takes(command, meant)) add(out, std::string(meant));
  if (out.empty()) add(out, nearest(word, known));
  return out;
}

std::string did_you_mean(const std::vector<std::string>& guesses) {
  std::string out;
  for (std::size_t i = 0; i < guesses.size(); ++i)
    out += fmt::format("{}\"{}\"",
                       i == 0                    ? ""
                       : i + 1 == guesses.size() ? " or "
                                                 : ", ",
                       guesses[i]);
  return out.empty() ? out : fmt::format("; did you mean {}?", out);
}

}  // namespace ddssec::cli
