// Suggestions for unknown words.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// Returns the known word that is most similar to `word`. Empty if none is similar.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// Returns at most four suggestions for words that begin no command: the same words in another
/// order ("create ca"), a verb without its group ("sign"), another verb of the same meaning ("ca
/// new"), a similar word. If the group is known, only second words are suggested.
std::vector<std::string> commands_like(std::span<const std::string> words);

/// Returns suggestions for an unknown option, with a value if that is meant ("--format json" for
/// "--json").
std::vector<std::string> options_like(std::string_view word, const Command& command);

/// Returns `; did you mean "a", "b" or "c"?`. Empty if there are no guesses.
std::string did_you_mean(const std::vector<std::string>& guesses);

}  // namespace ddssec::cli
