// What only one of two documents has, and other products read differently from ddssec.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// One construct that some product reads differently, or refuses.
struct Reading {
  bool is_new = false;     ///< only the new document has it; else only the old one
  std::string expression;  ///< the expression; empty: it is about something else
  std::string sentence;    ///< as lint says it
  int line = 0;            ///< where it stands first
  /// A participant has rights with Cyclone DDS that it does not have with ddssec.
  bool widens = false;
  /// A participant loses rights with a stock product that it keeps with ddssec.
  bool narrows = false;
};

struct Readings {
  /// Those of the new document first, each side by line.
  std::vector<Reading> all = {};
  /// False: there are more than kMostReadings, or more expressions than could be tried.
  bool is_complete = true;
};

inline constexpr std::size_t kMostReadings = 100;

/// Expressions of topics and partitions that Cyclone DDS or Fast DDS matches with other names, and
/// the readers' notes but those of open ranges. An expression that both documents have is left out,
/// wherever it stands. Verdicts do not depend on this: they say what ddssec decides.
Readings readings_of(const Governance& old_document, const Governance& new_document);
Readings readings_of(const Permissions& old_document, const Permissions& new_document);

}  // namespace ddssec::governance
