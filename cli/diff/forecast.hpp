// What running participants do with a changed document.
#pragma once

#include <string>

namespace ddssec::cli {

/// The most severe outcome and the first reason for it. `Live` lists its outcomes in the order of
/// severity, beginning with `same`.
template <class Live>
struct Forecast {
  Live outcome = Live::same;
  std::string reason = {};
  int line = 0;  ///< a line of the new document

  void add(Live next, const std::string& why, int at) {
    if (next <= outcome) return;
    outcome = next;
    reason = why;
    line = at;
  }
};

}  // namespace ddssec::cli
