// Sorts names into kinds that given expressions distinguish, and describes sets of kinds in words.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// A description of a set of names, for people.
struct NameSet {
  enum class Form : std::uint8_t {
    every,      ///< every name
    every_but,  ///< every name that none of `expressions` matches
    listed,     ///< every name that one of `expressions` matches
    some,       ///< no such description was found: names such as `examples`
  };
  Form form = Form::every;
  /// "" is the expression of the empty name.
  std::vector<std::string> expressions = {};
  /// One name for each kind in the set, the most readable one of the kind; never empty.
  std::vector<std::string> examples = {};

  bool is_only_empty_name() const {
    return form == Form::listed && expressions.size() == 1 && expressions.front().empty();
  }
};

/// All names, divided into kinds by expressions; the empty name is a separate kind.
class NameKinds {
 public:
  using Kind = std::uint32_t;

  /// Makes the kinds. Empty if a limit is reached.
  static std::optional<NameKinds> of(std::vector<std::string> expressions,
                                     const SetLimits& limits = {});

  /// Returns the number of kinds. The kind of the empty name is 0.
  std::size_t size() const { return examples_.size(); }
  const std::string& example(Kind kind) const { return examples_[kind]; }
  bool matches(std::size_t expression, Kind kind) const { return matched_[kind][expression]; }
  /// Returns the number of an expression that was given, or of "".
  std::size_t number_of(std::string_view expression) const;
  /// Describes `kinds`, which must be ascending and not empty.
  NameSet describe(std::span<const Kind> kinds) const;

 private:
  std::optional<std::vector<std::string>> covered_by(const std::vector<bool>& wanted) const;

  std::vector<std::string> expressions_;    ///< sorted; "" is among them
  std::vector<std::string> examples_;       ///< one of each kind
  std::vector<std::vector<bool>> matched_;  ///< for each kind, by which expressions
};

}  // namespace ddssec::governance
