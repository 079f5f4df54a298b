#include "plugins/authentication/adjusted_guid.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(AdjustedGuid, KnownInput_GivesTheReferenceValue) {
  Guid guid{{}, kEntityIdParticipant};
  for (std::uint8_t i = 0; i < 12; ++i) guid.prefix.octets[i] = static_cast<std::uint8_t>(i + 1);
  const Guid adjusted = adjusted_guid(sha256(as_bytes("abc")), guid);
  EXPECT_EQ(adjusted.to_string(), "dd3c0b5fc7806d4ad050a308.000001c1");
  EXPECT_TRUE(is_adjusted(adjusted));
  EXPECT_TRUE(is_bound_to(adjusted, sha256(as_bytes("abc"))));
}

TEST(AdjustedGuid, EveryOneOfThe48Bits_Counts) {
  const auto digest = sha256(as_bytes("abc"));
  const Guid adjusted = adjusted_guid(digest, candidate(1));
  for (std::size_t bit = 0; bit < 96; ++bit) {
    Guid other = adjusted;
    other.prefix.octets[bit / 8] ^= static_cast<std::uint8_t>(0x80u >> (bit % 8));
    EXPECT_EQ(is_bound_to(other, digest), bit >= 48) << bit;
  }
}

}  // namespace
}  // namespace ddssec::authentication
