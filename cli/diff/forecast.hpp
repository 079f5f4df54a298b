// Predicts what running participants do with a changed document.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ddssec::cli {

/// How an outcome is shown: by a word in the JSON, and by a text.
template <class Outcome>
struct OutcomeWords {
  Outcome outcome;
  std::string_view word, text;
};

/// Returns the row of the outcome. A table has a row for each outcome, in their order.
template <class Outcome, std::size_t kCount>
constexpr const OutcomeWords<Outcome>& words_of(const OutcomeWords<Outcome> (&table)[kCount],
                                                Outcome outcome) {
  return table[static_cast<std::size_t>(outcome)];
}

/// The most severe outcome and the first reason for it. `Outcome` lists them in the order of
/// severity, beginning with `same`.
template <class Outcome>
struct Forecast {
  Outcome outcome = Outcome::same;
  std::string reason = {};
  int line = 0;  ///< a line of the new document

  void add(Outcome next, const std::string& why, int at) {
    if (next <= outcome) return;
    outcome = next;
    reason = why;
    line = at;
  }
};

}  // namespace ddssec::cli
