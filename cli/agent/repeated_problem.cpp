#include "cli/agent/repeated_problem.hpp"

namespace ddssec::cli {

bool RepeatedProblem::note(Code code, Moment now) {
  if (last_ == code && now - reported_ < kPause) return false;
  last_ = code;
  reported_ = now;
  return true;
}

}  // namespace ddssec::cli
