// The version of the OpenSSL that is loaded.
#include "base/openssl_version.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(OpensslVersion, LoadedLibrary_GivesItsText) {
  EXPECT_TRUE(openssl_version().starts_with("OpenSSL 3.")) << openssl_version();
}

}  // namespace
}  // namespace ddssec
