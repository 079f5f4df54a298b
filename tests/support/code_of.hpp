// Finds the code with which a call was refused.
#pragma once

#include "base/result.hpp"

namespace ddssec::test {

/// Returns the code of the refusal; Code{} if the call was not refused.
template <class T>
Code code_of(const Result<T>& result) {
  return result ? Code{} : result.error().code();
}

}  // namespace ddssec::test
