// The plugin that each set of options makes.
#include "plugins/cryptography/cryptography.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kSign = ProtectionKind::sign;

TEST(Backends, MissingBackend_IsReplacedWithAnEvent) {
  Side side(CryptographyOptions{.aead = static_cast<AeadChoice>(200)});
  EXPECT_EQ(side.events.codes(), std::vector{Code::aead_backend_unavailable});
  EXPECT_TRUE(side.factory().register_local_participant({}, {}, {}, participant_attributes(kSign)));
  EXPECT_TRUE(Side().events.codes().empty());
}

}  // namespace
}  // namespace ddssec::cryptography::testing
