// Finds functions that the libraries of this process export, by the end of their names.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ddssec::cyclonedds {

/// A symbol of the process, and the library that defines it.
struct LoadedSymbol {
  std::string library;  ///< its path; empty for the program itself
  std::string name;
};

/// Finds a symbol that a loaded library or the program defines and whose name ends with `suffix`
/// (and is longer); empty if there is none. Searches every dynamic symbol table, which takes some
/// milliseconds in a large process.
std::optional<LoadedSymbol> find_loaded_symbol(std::string_view suffix);

}  // namespace ddssec::cyclonedds
