// Peers that prove that they have ended their session.
#include "rtps/security/session_ends.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

constexpr GuidPrefix kPeer{{2}}, kOther{{3}};
constexpr MonotonicTime kNow{100s};

spi::SharedSecret secret(std::uint8_t first) {
  spi::SharedSecret out;
  out.secret = *spi::SharedSecretOctets::copy_of(Bytes(32, first));
  return out;
}

struct SessionEndsTest : ::testing::Test {
  SessionEndsTest() { ends.expect(kPeer, secret(1)); }
  void receive(const GuidPrefix& from, const spi::SharedSecret& of, const GuidPrefix& sender) {
    const auto message = spi::write_reset(sender, spi::derive_reset_token(of, sender));
    ends.note_reset(from, *spi::read_reset(message), kNow);
  }
  SessionEnds ends;
};

TEST_F(SessionEndsTest, AProvenEnd_IsTakenOnceAndInTime) {
  receive(kPeer, secret(1), kPeer);
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow));
  EXPECT_TRUE(ends.remove_if_before(kPeer, kNow + 1ns));
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1ns));
  receive(kPeer, secret(1), kPeer);
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1s)) << "a repetition";
}

TEST_F(SessionEndsTest, AProvenEnd_HoldsUntilAnotherSessionBegins) {
  EXPECT_FALSE(ends.has_ended(kPeer));
  EXPECT_FALSE(ends.take_proven());
  std::vector<GuidPrefix> proven;
  ends.on_proven([&](const GuidPrefix& peer, MonotonicTime) { proven.push_back(peer); });
  receive(kPeer, secret(2), kPeer);
  EXPECT_FALSE(ends.has_ended(kPeer)) << "no proof";
  receive(kPeer, secret(1), kPeer);
  EXPECT_TRUE(ends.has_ended(kPeer));
  EXPECT_TRUE(ends.take_proven());
  EXPECT_FALSE(ends.take_proven()) << "taken before";
  receive(kPeer, secret(1), kPeer);
  EXPECT_FALSE(ends.take_proven()) << "a repetition";
  EXPECT_EQ(proven, std::vector{kPeer});
  ends.expect(kPeer, secret(2));
  EXPECT_FALSE(ends.has_ended(kPeer));
  EXPECT_FALSE(ends.has_ended(kOther));
}

TEST_F(SessionEndsTest, MessageWithoutAProof_EndsNothing) {
  receive(kPeer, secret(2), kPeer);   // the secret of another session
  receive(kPeer, secret(1), kOther);  // a message of the other side
  receive(kOther, secret(1), kPeer);  // in the name of another peer
  const spi::ResetToken nothing{.name = {}, .proof = *spi::ResetProof::copy_of(Bytes(32))};
  ends.note_reset(kPeer, *spi::read_reset(spi::write_reset(kPeer, nothing)), kNow);
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1s));
  EXPECT_FALSE(ends.remove_if_before(kOther, kNow + 1s));
}

TEST_F(SessionEndsTest, ANewSession_IsNotEnded) {
  receive(kPeer, secret(1), kPeer);
  ends.expect(kPeer, secret(2));
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1s));
  receive(kPeer, secret(1), kPeer);
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1s)) << "recorded";
  receive(kPeer, secret(2), kPeer);
  EXPECT_TRUE(ends.remove_if_before(kPeer, kNow + 1s));
}

TEST_F(SessionEndsTest, AForgottenPeer_HasNone) {
  ends.forget(kPeer);
  receive(kPeer, secret(1), kPeer);
  EXPECT_FALSE(ends.remove_if_before(kPeer, kNow + 1s));
}

}  // namespace
}  // namespace ddssec::rtps
