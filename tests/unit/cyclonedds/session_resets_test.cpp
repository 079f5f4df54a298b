#include "plugins/cyclonedds/session_resets.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

constexpr GuidPrefix kPeer{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};

spi::ResetToken token_of(std::uint8_t session) {
  spi::SharedSecret secret;
  secret.secret = *spi::SharedSecretOctets::copy_of(Bytes(32, session));
  return spi::derive_reset_token(secret, kPeer);
}

Bytes message_of(std::uint8_t session) { return spi::write_reset(kPeer, token_of(session)); }

bool receive(SessionResets& resets, const Bytes& message) {
  return resets.received(*spi::read_reset(message));
}

TEST(SessionResets, AreTakenOnce) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  EXPECT_FALSE(resets.take({7}));
  EXPECT_TRUE(receive(resets, message_of(1)));
  EXPECT_TRUE(receive(resets, message_of(1)));  // sent again
  EXPECT_FALSE(resets.take({8}));
  EXPECT_TRUE(resets.take({7}));
  EXPECT_FALSE(resets.take({7}));
}

TEST(SessionResets, NeedTheProofOfASessionThatIsThere) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  EXPECT_FALSE(receive(resets, message_of(2)));
  auto forged = message_of(1);
  forged[forged.size() - 25] ^= 1;  // last octet of the proof
  EXPECT_FALSE(receive(resets, forged));
  EXPECT_FALSE(resets.take({7}));
  resets.forget({70});
  EXPECT_FALSE(receive(resets, message_of(1)));
  EXPECT_FALSE(resets.take({7}));
}

// Its end is the reason why the peer has lost the session.
TEST(SessionResets, OfALocalParticipantThatEnded_ResetNoOther) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  resets.expect({{70}, {2}}, {7}, token_of(2));
  resets.forget({2});
  EXPECT_FALSE(receive(resets, message_of(2)));
  EXPECT_FALSE(resets.take({7}));
  EXPECT_TRUE(receive(resets, message_of(1)));
  EXPECT_TRUE(resets.take({7}));
}

TEST(SessionResets, OfAForgottenPeerAreNotWaitedFor) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  resets.expect({{70}, {1}}, {7}, token_of(2));  // a second local participant
  EXPECT_TRUE(receive(resets, message_of(2)));
  resets.forget({70});
  EXPECT_FALSE(resets.take({7}));
  resets.expect({{71}, {1}}, {7},
                token_of(3));  // the next session is not reset by the former's token
  EXPECT_FALSE(receive(resets, message_of(2)));
  EXPECT_FALSE(resets.take({7}));
}

}  // namespace
}  // namespace ddssec::cyclonedds
