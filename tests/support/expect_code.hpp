// Expectations of what a call returns.
#pragma once

#include <gtest/gtest.h>

#include "base/result.hpp"

/// Fails unless `result` is an error of exactly this code.
#define EXPECT_CODE(result, expected_code)                                                     \
  do {                                                                                         \
    const auto& result_ = (result);                                                            \
    if (result_)                                                                               \
      ADD_FAILURE() << #result " succeeded";                                                   \
    else                                                                                       \
      EXPECT_EQ(result_.error().code(), Code::expected_code) << result_.error().to_sentence(); \
  } while (false)

#define ASSERT_OK(result) ASSERT_TRUE(result) << (result).error().to_sentence()
