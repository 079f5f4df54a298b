// Expressions written from what they are to match.
#pragma once

#include <bitset>
#include <string>
#include <string_view>

#include "governance/matcher.hpp"

namespace ddssec::governance {

/// An expression that matches no name.
inline constexpr std::string_view kMatchesNothing = "[!\x01-\xff]";

/// Whether every product takes the octet for itself in an expression: a letter, a digit or "_".
bool is_word(char c);

/// The expression that matches just this name.
std::string expression_of(std::string_view name);
/// An expression for one of these octets; NUL, which no name holds, is left out.
std::string expression_of(const std::bitset<256>& octets);
/// An expression for what one step of the pattern matches.
std::string expression_of(const Pattern& pattern, const Pattern::Step& step);

}  // namespace ddssec::governance
