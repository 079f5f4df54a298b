// Matches names with one expression of a governance or permissions document: POSIX fnmatch.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance {

/// One compiled expression, with `*`, `?`, `[...]` with ranges, `!` or `^` and character classes of
/// ASCII, and a backslash before a literal character. `*` matches `/` and a leading dot; `?` is one
/// octet. A `[` without its `]` is literal. An expression that ends with a single backslash matches
/// nothing.
///
/// The same as fnmatch(3) of glibc without flags in the C locale (DDS-Security 1.2,
/// clauses 10.4.1.2.6.1 and 10.4.1.5.3.4.1.3). The name is always literal, whatever characters it
/// contains. Compilation is linear in the length of the expression. Matching takes at most its
/// length times the name's.
class Pattern {
 public:
  enum class Syntax : std::uint8_t {
    name,                ///< topics, partitions and domain tags
    verbatim_backslash,  ///< FNM_NOESCAPE: as Fast DDS reads names
    subject,  ///< FNM_PATHNAME and FNM_NOESCAPE (1.2 10.4.1.5.3.2.1): only a '/' matches a '/'
  };

  explicit Pattern(std::string_view expression, Syntax syntax = Syntax::name);

  bool matches(std::string_view name) const;
  /// As matches(name), with at most `steps` steps, which are subtracted; empty if they do not
  /// suffice.
  std::optional<bool> matches(std::string_view name, std::size_t& steps) const;
  /// True if no name can match, as with `[z-a]`.
  bool matches_no_name() const;
  /// True if it matches exactly one name, text().
  bool is_literal() const { return steps_.empty(); }
  /// Returns the name that a literal matches, otherwise the expression.
  const std::string& text() const { return text_; }

  enum class Kind : std::uint8_t { character, any, star, set };
  struct Step {
    Kind kind;
    std::uint8_t character;  ///< Kind::character
    std::uint16_t set;       ///< Kind::set: index
  };
  /// Returns the steps; none for a literal.
  const std::vector<Step>& steps() const { return steps_; }
  /// Returns the octets that a step of Kind::set matches.
  const std::bitset<256>& set_of(const Step& step) const { return sets_[step.set]; }

 private:
  class SetReader;

  bool step_matches(const Step& step, char c) const;
  /// Parses the step that begins at text_[at]; returns its length.
  std::size_t read_step(std::size_t at, SetReader& sets);
  /// Parses a bracket expression at text_[at]; returns its length, or 0 if there is none.
  std::size_t read_set(std::size_t at, SetReader& sets);
  void add_set(const std::bitset<256>& set);

  std::string text_;
  std::vector<Step> steps_;
  std::vector<std::bitset<256>> sets_;
  Syntax syntax_;
};

}  // namespace ddssec::governance
