// For EXPECT_TRUE and ASSERT_TRUE about a Result: a failure shows the error's sentence.
#pragma once

#include <gtest/gtest.h>

#include "base/result.hpp"

namespace ddssec::test {

template <class T>
::testing::AssertionResult succeeds(const Result<T>& result) {
  if (result) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << result.error().to_sentence();
}

}  // namespace ddssec::test
