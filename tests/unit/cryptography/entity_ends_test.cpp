// The entities that are unregistered together with their participant.

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(Unregistering, UnregisteredParticipant_TakesItsOwnEntitiesWithIt) {
  TwoSides two(kEncrypt);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto encoded = encode_payload(two, e, Bytes(8)).value();
  ASSERT_TRUE(two.b.factory().unregister_participant(two.b.remote));
  EXPECT_EQ(code_of(decode_payload(two, e, encoded)), Code::crypto_handle_unknown);
  EXPECT_EQ(code_of(two.b.factory().unregister_datawriter(e.remote_writer)),
            Code::crypto_handle_unknown);
  ASSERT_TRUE(two.a.factory().unregister_participant(two.a.participant));
  EXPECT_EQ(code_of(encode_payload(two, e, Bytes(8))), Code::crypto_handle_unknown);
  EXPECT_EQ(code_of(two.a.factory().unregister_datareader(e.remote_reader)),
            Code::crypto_handle_unknown);
  Bytes out(100);
  EXPECT_EQ(code_of(two.a.transform().preprocess_secure_submessage({}, two.a.remote, out)),
            Code::secure_group_malformed)
      << "the remote participant is still there";
  EXPECT_TRUE(two.a.factory().unregister_participant(two.a.remote));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
