// Finds constructs that only one of two documents has and that other products read differently from
// ddssec.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// One construct that some product reads differently or refuses.
struct Interpretation {
  bool is_new = false;     ///< true if only the new document has it, false if only the old one
  std::string expression;  ///< the expression; empty if it is another construct
  std::string sentence;    ///< the sentence of lint
  int line = 0;            ///< line of its first occurrence
  /// True if a participant has rights with Cyclone DDS that it does not have with ddssec.
  bool widens = false;
  /// True if a participant loses rights with a stock product that it keeps with ddssec.
  bool narrows = false;
};

/// The places of two documents that products interpret differently.
struct Interpretations {
  /// The interpretations of the new document first, each side by line.
  std::vector<Interpretation> all = {};
  /// False if there are more than kMaxInterpretations, or more expressions than could be tried.
  bool is_complete = true;
};

inline constexpr std::size_t kMaxInterpretations = 100;

/// Finds expressions of topics and partitions that match other names with Cyclone DDS or Fast DDS,
/// and the readers' notes except those about open ranges. An expression that occurs in both
/// documents is left out, wherever it is. Verdicts do not depend on this: they describe the
/// decisions of ddssec.
Interpretations interpretations_of(const Governance& old_document, const Governance& new_document);
Interpretations interpretations_of(const Permissions& old_document,
                                   const Permissions& new_document);

}  // namespace ddssec::governance
