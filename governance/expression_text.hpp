// Writes expressions for what they must match.
#pragma once

#include <bitset>
#include <string>
#include <string_view>

#include "governance/pattern.hpp"

namespace ddssec::governance {

/// An expression that matches no name.
inline constexpr std::string_view kMatchesNothing = "[!\x01-\xff]";

/// True if every product reads the octet literally in an expression: a letter, a digit or "_".
bool is_word(char c);

/// Returns the expression that matches just this name.
std::string expression_of(std::string_view name);
/// Returns an expression that matches any one of these octets, except NUL, which occurs in no name.
std::string expression_of(const std::bitset<256>& octets);
/// Returns an expression that matches the same as one step of the pattern.
std::string expression_of(const Pattern& pattern, const Pattern::Step& step);

}  // namespace ddssec::governance
