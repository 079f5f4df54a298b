// The session keys of a sender, as its receiver finds them.
#include "plugins/cryptography/receive_key.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kNone = ProtectionKind::none;

TEST(ReceivedSessions, OldOnes_StayReadableWhileNewOnesCome) {
  TwoSides two(kNone, {}, {.max_blocks_per_session = 1});
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  std::vector<Bytes> encoded;
  for (std::uint8_t i = 0; i < 40; ++i)
    encoded.push_back(encode_payload(two, e, Bytes(20, i)).value());
  for (int round = 0; round < 3; ++round)
    for (std::uint8_t i = 0; i < 40; ++i)
      EXPECT_EQ(decode_payload(two, e, encoded[static_cast<std::size_t>(39 - i)]).value(),
                Bytes(20, static_cast<std::uint8_t>(39 - i)));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
