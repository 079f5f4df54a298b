// Key tokens that pass between the host and the plugin.
#include <algorithm>
#include <utility>

#include "tests/unit/cyclonedds/cryptography_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::cryptography_adapters {
namespace {

using testing::_;
using testing::Return;

TEST_F(CryptographyAdapterTest, CryptoTokens_GoOutAndIn) {
  const std::vector<spi::Token> two = {sample_token(), {.class_id = "second"}};
  ON_CALL(plugin, create_local_participant_crypto_tokens).WillByDefault(Return(two));
  ON_CALL(plugin, create_local_datawriter_crypto_tokens).WillByDefault(Return(two));
  ON_CALL(plugin, create_local_datareader_crypto_tokens)
      .WillByDefault(Return(std::vector<spi::Token>{}));
  const auto is_two = testing::Truly(
      [&](std::span<const spi::Token> tokens) { return std::ranges::equal(tokens, two); });
  EXPECT_CALL(plugin, set_remote_participant_crypto_tokens(_, _, is_two))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, set_remote_datawriter_crypto_tokens(spi::DatareaderCryptoHandle{3},
                                                          spi::DatawriterCryptoHandle{4}, is_two))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, set_remote_datareader_crypto_tokens(spi::DatawriterCryptoHandle{4},
                                                          spi::DatareaderCryptoHandle{3}, is_two))
      .WillOnce(Return(fail(Code::malformed)));

  DDS_Security_CryptoTokenSeq tokens{};
  ASSERT_EQ(exchange->create_local_participant_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  ASSERT_EQ(tokens._length, 2u);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_datawriter_crypto_tokens(exchange, 3, 4, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_datareader_crypto_tokens(exchange, 4, 3, &tokens, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::malformed);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, nullptr, nullptr), 1);

  ASSERT_EQ(exchange->create_local_datareader_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  EXPECT_EQ(tokens._length, 0u);
  EXPECT_EQ(tokens._buffer, nullptr);
  ASSERT_EQ(exchange->create_local_datawriter_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  exchange->return_crypto_tokens(exchange, &tokens, nullptr);

  EXPECT_EQ(exchange->create_local_participant_crypto_tokens(exchange, nullptr, 1, 2, nullptr), 0);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, nullptr, nullptr), 0);
  EXPECT_EQ(exchange->return_crypto_tokens(nullptr, &tokens, nullptr), 0);
}

// If a participant's tokens are refused, Cyclone DDS does not free them, and logs each refusal.
TEST_F(CryptographyAdapterTest, RefusedParticipantTokens_AreToldOnceAndTakenFromTheHost) {
  EXPECT_CALL(plugin, set_remote_participant_crypto_tokens)
      .WillOnce(Return(fail(Code::keys_already_set)))
      .WillOnce(Return(fail(Code::crypto_handle_unknown)));
  const std::vector<spi::Token> one = {sample_token()};
  ON_CALL(plugin, create_local_participant_crypto_tokens).WillByDefault(Return(one));
  DDS_Security_CryptoTokenSeq tokens{};
  ASSERT_EQ(exchange->create_local_participant_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, &refusal), 1);
  ASSERT_EQ(harness.events.size(), 1u);
  EXPECT_EQ(harness.events[0].error.code(), Code::keys_already_set);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::crypto_handle_unknown);

  const auto length = std::exchange(tokens._length, spi::kMaxTokensPerMessage + 1);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, nullptr), 1);
  EXPECT_EQ(harness.events.back().error.code(), Code::length_out_of_range);
  tokens._length = length;
  exchange->return_crypto_tokens(exchange, &tokens, nullptr);
}

}  // namespace
}  // namespace ddssec::cyclonedds::cryptography_adapters
