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
  return resets.note_reset(*spi::read_reset(message));
}

SessionReset take(SessionResets& resets, spi::IdentityHandle peer) {
  return resets.take(peer, PeersWithKeys());
}

TEST(SessionResets, OneReset_IsTakenOnce) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
  EXPECT_TRUE(receive(resets, message_of(1)));
  EXPECT_TRUE(receive(resets, message_of(1)));  // it was sent again
  EXPECT_EQ(take(resets, {8}), SessionReset::none);
  EXPECT_EQ(take(resets, {7}), SessionReset::of_session);
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
}

TEST(SessionResets, WrongProof_IsRefused) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  EXPECT_FALSE(receive(resets, message_of(2)));
  auto forged = message_of(1);
  forged[forged.size() - 25] ^= 1;  // the last octet of the proof
  EXPECT_FALSE(receive(resets, forged));
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
  resets.forget({70});
  EXPECT_FALSE(receive(resets, message_of(1)));
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
}

// The peer lost the session because this participant ended.
TEST(SessionResets, EndOfALocalParticipant_ResetsNoOther) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  resets.expect({{70}, {2}}, {7}, token_of(2));
  resets.forget({2});
  EXPECT_FALSE(receive(resets, message_of(2)));
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
  EXPECT_TRUE(receive(resets, message_of(1)));
  EXPECT_EQ(take(resets, {7}), SessionReset::of_session);
}

// For example, the peer refused the permissions of the second local participant.
TEST(SessionResets, SessionsWithAndWithoutKeys_AreToldApart) {
  SessionResets resets;
  PeersWithKeys peers;
  for (const std::uint8_t local : {1, 2}) {
    resets.expect({{70}, {local}}, {7}, token_of(local));
    peers.note_discovered({70}, {7}, {local}, 0);
  }
  const auto reset = [&](std::uint8_t local) {
    EXPECT_TRUE(receive(resets, message_of(local)));
    return resets.take({7}, peers);
  };
  EXPECT_EQ(reset(2), SessionReset::of_session) << "no keys came at all";
  peers.note_keys_sent({70}, {1});
  EXPECT_EQ(reset(2), SessionReset::of_unused_session);
  EXPECT_EQ(reset(1), SessionReset::of_session);
  EXPECT_TRUE(receive(resets, message_of(2)));
  EXPECT_EQ(reset(1), SessionReset::of_session) << "both";
  peers.note_keys_sent({70}, {2});
  EXPECT_EQ(reset(2), SessionReset::of_session);
}

TEST(SessionResets, ForgottenPeer_IsNotWaitedFor) {
  SessionResets resets;
  resets.expect({{70}, {1}}, {7}, token_of(1));
  resets.expect({{70}, {1}}, {7}, token_of(2));  // the token of a second local participant
  EXPECT_TRUE(receive(resets, message_of(2)));
  resets.forget({70});
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
  resets.expect({{71}, {1}}, {7},
                token_of(3));  // the token of the former session does not reset the next one
  EXPECT_FALSE(receive(resets, message_of(2)));
  EXPECT_EQ(take(resets, {7}), SessionReset::none);
}

}  // namespace
}  // namespace ddssec::cyclonedds
