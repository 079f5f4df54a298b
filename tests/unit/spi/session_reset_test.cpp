#include "plugins/spi/session_reset.hpp"

#include <gtest/gtest.h>

#include "base/hash.hpp"

namespace ddssec::spi {
namespace {

constexpr GuidPrefix kA{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr GuidPrefix kB{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13}};

SharedSecret secret_of(std::uint8_t octet) {
  SharedSecret secret;
  secret.secret = *SharedSecretOctets::copy_of(Bytes(32, octet));
  secret.challenge1.fill(2);
  secret.challenge2.fill(3);
  return secret;
}

Bytes proof_of(const ResetToken& token) {
  return token.proof.expose([](BytesView view) { return to_bytes(view); });
}

TEST(SessionReset, BothSides_DeriveTheSameToken) {
  const auto one = derive_reset_token(secret_of(1), kA),
             other = derive_reset_token(secret_of(1), kA);
  EXPECT_EQ(one.name, other.name);
  EXPECT_EQ(proof_of(one), proof_of(other));
  EXPECT_EQ(one.proof.size(), 32u);
}

TEST(SessionReset, EverySessionAndEachDirection_HasItsOwn) {
  const auto token = derive_reset_token(secret_of(1), kA);
  auto later = secret_of(1);
  later.challenge2.fill(4);
  for (const auto& other : {derive_reset_token(secret_of(2), kA),
                            derive_reset_token(secret_of(1), kB), derive_reset_token(later, kA)}) {
    EXPECT_NE(token.name, other.name);
    EXPECT_NE(proof_of(token), proof_of(other));
  }
  EXPECT_NE(to_hex(token.name), to_hex(BytesView(proof_of(token)).first(16)));
}

TEST(SessionReset, WrittenMessage_ReadsBack) {
  const auto token = derive_reset_token(secret_of(1), kA);
  const auto message = write_reset(kA, token);
  EXPECT_EQ(to_hex(BytesView(message).first(4)), to_hex(as_bytes("RTPS")));
  EXPECT_EQ(to_hex(BytesView(message).subspan(8, 12)), to_hex(kA.view()));
  EXPECT_EQ(message[20], 0x33);
  const auto read = read_reset(message);
  ASSERT_TRUE(read);
  EXPECT_EQ(to_hex(read->name), to_hex(token.name));
  EXPECT_EQ(to_hex(read->proof), to_hex(proof_of(token)));
}

TEST(SessionReset, OtherMessages_AreNone) {
  const auto message = write_reset(kA, derive_reset_token(secret_of(1), kA));
  for (std::size_t size = 0; size < message.size(); ++size)
    EXPECT_FALSE(read_reset(BytesView(message).first(size)));
  auto longer = message;
  longer.push_back(0);
  EXPECT_FALSE(read_reset(longer));
  for (std::size_t at = 24; at < 28; ++at) {
    auto of_another_kind = message;
    of_another_kind[at] ^= 1;
    EXPECT_FALSE(read_reset(of_another_kind));
  }
}

}  // namespace
}  // namespace ddssec::spi
