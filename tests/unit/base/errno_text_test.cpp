#include "base/errno_text.hpp"

#include <cerrno>

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(ErrnoText, KnownNumber_GivesTheSystemsText) {
  EXPECT_EQ(errno_text(ENOENT), "No such file or directory");
}

TEST(ErrnoText, UnknownNumber_IsNamed) {
  EXPECT_NE(errno_text(123'456).find("123456"), std::string::npos);
}

}  // namespace
}  // namespace ddssec
