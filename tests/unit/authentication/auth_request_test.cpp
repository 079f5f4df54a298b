#include "plugins/authentication/auth_request.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(AuthRequest, ValidRequest_RoundTrips) {
  Challenge challenge;
  challenge.fill(7);
  const auto read = read_auth_request(write_auth_request(challenge));
  ASSERT_OK(read);
  EXPECT_EQ(*read, challenge);
}

TEST(AuthRequest, MalformedRequests_AreRefusedWithTheirCodes) {
  Token wrong_class = sample();
  wrong_class.class_id = "DDS:Auth:PKI-DH:1.0+Req";
  EXPECT_CODE(read_auth_request(wrong_class), token_class_wrong);
  EXPECT_CODE(read_auth_request(without(sample(), "future_challenge")), token_field_missing);
  for (const std::size_t size : {0u, 31u, 33u})
    EXPECT_CODE(read_auth_request(with(sample(), "future_challenge", Bytes(size))),
                token_field_length);
  Token twice = sample();
  twice.binary_properties.push_back(twice.binary_properties[0]);
  EXPECT_CODE(read_auth_request(twice), token_field_repeated);
}

}  // namespace
}  // namespace ddssec::authentication
