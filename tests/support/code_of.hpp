// The code with which something was refused.
#pragma once

#include "base/result.hpp"

namespace ddssec::test {

/// Code{}: it was not refused.
template <class T>
Code code_of(const Result<T>& result) {
  return result ? Code{} : result.error().code();
}

}  // namespace ddssec::test
