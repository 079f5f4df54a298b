// Limits how often the agent reports a problem that stays.
#pragma once

#include <chrono>
#include <optional>

#include "base/code.hpp"

namespace ddssec::cli {

/// A problem of one folder that the agent sees at each visit, and reports once a day.
class RepeatedProblem {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  static constexpr std::chrono::hours kPause{24};

  /// Notes the problem. Returns true if it is to be reported now: the last one had another code, or
  /// was reported kPause ago.
  bool note(Code code, Moment now);
  /// Call this when the problem has gone: the next one is then reported at once.
  void clear() { last_.reset(); }

 private:
  std::optional<Code> last_ = {};
  Moment reported_{0};
};

}  // namespace ddssec::cli
