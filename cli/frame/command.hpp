// The table of commands. The parser, the help and the tests are generated from it.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/answer.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// An argument that is identified by its position.
struct Positional {
  std::string_view name;  ///< as in the help, such as "DIR"
  std::string_view summary;
  bool optional = false;         ///< may be left out
  bool repeated = false;         ///< may be given more than once; only the last of a command
  std::string_view unless = {};  ///< the option that must be given if this is left out
};

/// An argument that is identified by its name.
struct Option {
  std::string_view name;   ///< "--days"
  std::string_view value;  ///< as in the help, such as "N"; empty for a flag
  std::string_view summary;
  std::string_view fallback = {};  ///< the default value
  bool repeated = false;           ///< may be given more than once
  bool required = false;
  std::string_view letter = {};  ///< a short form, such as "-q"

  /// Returns every way to write it, such as "-q,--quiet".
  std::string spellings() const;
};

/// The parsed command line, with the names of the table. Every value is given or has its default.
class Arguments {
 public:
  using Values = std::map<std::string, std::vector<std::string>, std::less<>>;
  explicit Arguments(Values values) : values_(std::move(values)) {}

  bool has(std::string_view name) const { return values_.contains(name); }
  /// Returns the value, or the last one of several. Empty if there is none.
  std::string text(std::string_view name) const;
  const std::vector<std::string>& all(std::string_view name) const;
  /// Returns the value as an integer. Error: usage.
  Result<int> number(std::string_view name, int lowest, int highest) const;

 private:
  Values values_;
};

/// The services that a command gets besides its arguments.
struct Context {
  const Clock& clock;
  Random& random;
};

/// One command.
struct Command {
  std::string_view group;  ///< such as "ca"; empty for a command of one word
  std::string_view name;
  std::string_view summary;
  std::vector<Positional> positionals;
  std::vector<Option> options;
  std::vector<std::string_view> examples;
  Runner run;
  /// What the user probably wants if there is one argument too many, as the end of a sentence.
  std::string_view instead_of_extra = {};
  /// Other groups in which users look for this command.
  std::vector<std::string_view> sought_in = {};

  /// Returns a text such as "ca create".
  std::string full_name() const;
};

/// Returns every command, by group.
const std::vector<Command>& commands();
/// Returns the options that every command accepts.
const std::vector<Option>& common_options();

}  // namespace ddssec::cli
