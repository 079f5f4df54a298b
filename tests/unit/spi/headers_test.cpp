// Each interface header compiles on its own, and handles of different kinds cannot be mixed up.
#include <type_traits>

#include <gtest/gtest.h>

#include "plugins/spi/access_control.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/cryptography.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

static_assert(!std::is_convertible_v<IdentityHandle, PermissionsHandle>);
static_assert(!std::is_copy_constructible_v<SharedSecret>);

TEST(Handle, Zero_IsNil) {
  EXPECT_FALSE(IdentityHandle{});
  EXPECT_TRUE(IdentityHandle{1});
}

}  // namespace
}  // namespace ddssec::spi
