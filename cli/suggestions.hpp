// What a person may have meant by words that are not known.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command.hpp"

namespace ddssec::cli {

/// The known word that is nearest to `word`, or "" if none is near.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// Commands that words which begin with no command may stand for, at most four: the same words the
/// other way round ("create ca"), a verb without its group ("sign"), another verb of the same
/// meaning ("ca new"), a word that is near. Behind a group: second words.
std::vector<std::string> commands_like(std::span<const std::string> words);

/// Options of the command that an unknown one may stand for, with a value where that is meant
/// ("--format json" for "--json").
std::vector<std::string> options_like(std::string_view word, const Command& command);

/// `; did you mean "a", "b" or "c"?`; "" for none.
std::string did_you_mean(const std::vector<std::string>& guesses);

}  // namespace ddssec::cli
