// What happens to a request when the host drops a peer and meets it again. Stock plugins answer the
// first request that they saw, and no other.
#include "plugins/authentication/kept_requests.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

struct KeptRequest : ::testing::Test {
  // The host of the participant that begins drops the other one, and meets it again.
  void meet_again() {
    ASSERT_OK((*two.low.plugin)->return_identity_handle(two.high_at_low));
    const auto again = two.low.discover(two.high);
    ASSERT_OK(again);
    two.high_at_low = again->handle;
  }
  void invent(std::size_t count);
  Token request() {
    const auto step = two.request();
    EXPECT_TRUE(step);
    return step ? *step->message : Token{};
  }

  Pairing pairing;
  Two& two = pairing.two;
};

TEST_F(KeptRequest, RepeatedRequest_IsTheSameAndItsAnswerCounts) {
  const auto first = two.request();
  ASSERT_OK(first);
  const auto reply = two.reply(*first->message);
  ASSERT_OK(reply);
  for (int times = 0; times < 3; ++times) meet_again();
  const auto again = two.request();
  ASSERT_OK(again);
  EXPECT_EQ(*again->message, *first->message);
  EXPECT_CODE(two.process_at_lower_guid(first->handle, *reply->message), unknown_handshake);
  pairing.expect_finish(*again, *reply);
}

TEST_F(KeptRequest, RequestAfterAnHour_IsForgotten) {
  const auto first = request();
  meet_again();
  EXPECT_EQ(request(), first);
  two.low.plugin->clock.advance(KeptRequests::kLife + 1s);
  meet_again();
  EXPECT_NE(request(), first);
}

TEST_F(KeptRequest, AnsweredRequest_IsNotKept) {
  const auto first = two.request();
  ASSERT_OK(first);
  const auto reply = two.reply(*first->message);
  ASSERT_OK(reply);
  ASSERT_OK(two.process_at_lower_guid(first->handle, *reply->message));
  meet_again();
  EXPECT_NE(request(), *first->message);
}

// Begins handshakes with `count` other participants, and drops them.
void KeptRequest::invent(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    auto guid = two.high.guid;
    guid.prefix.octets[10] = static_cast<std::uint8_t>(i + 1);
    guid.prefix.octets[11] = static_cast<std::uint8_t>(i >> 8);
    const auto other =
        (*two.low.plugin)->validate_remote_identity(two.low.handle, {}, two.high.token, guid);
    ASSERT_OK(other);
    ASSERT_OK(
        (*two.low.plugin)->begin_handshake_request(two.low.handle, other->handle, two.low.data));
    ASSERT_OK((*two.low.plugin)->return_identity_handle(other->handle));
  }
}

TEST_F(KeptRequest, StrangersInventingOthers_DoNotDisplaceIt) {
  const auto first = request();
  ASSERT_OK((*two.low.plugin)->return_identity_handle(two.high_at_low));
  two.low.plugin->clock.advance(1s);
  invent(KeptRequests::kMax);  // the oldest request is not the first to go
  const auto again = two.low.discover(two.high);
  ASSERT_OK(again);
  two.high_at_low = again->handle;
  EXPECT_EQ(request(), first);
}

TEST_F(KeptRequest, TooManyRequests_TheFirstIsForgotten) {
  const auto first = request();
  ASSERT_OK((*two.low.plugin)->return_identity_handle(two.high_at_low));
  invent(10 * KeptRequests::kMax);
  const auto again = two.low.discover(two.high);
  ASSERT_OK(again);
  two.high_at_low = again->handle;
  EXPECT_NE(request(), first);
}

// Stock plugins accept no reply with another challenge than the one that we announced first. They
// keep to the first reply that they get, which may be one that the host gave up. Their final
// message must verify nevertheless.
TEST_F(KeptRequest, ReplierMeetingAgain_KeepsItsChallengeAndKey) {
  const auto request = two.request();
  ASSERT_OK(request);
  const auto first = two.reply(*request->message);
  ASSERT_OK(first);
  ASSERT_OK((*two.high.plugin)->return_identity_handle(two.low_at_high));
  const auto again = two.high.discover(two.low);
  ASSERT_OK(again);
  two.low_at_high = again->handle;
  const auto second = two.reply(*request->message);
  ASSERT_OK(second);
  EXPECT_EQ(field(*second->message, "challenge2"), field(*first->message, "challenge2"));
  EXPECT_EQ(field(*second->message, "dh2"), field(*first->message, "dh2"));
  const auto final = two.process_at_lower_guid(request->handle, *first->message);
  ASSERT_OK(final);
  const auto done = two.process_at_higher_guid(second->handle, *final->message);
  ASSERT_OK(done);
  EXPECT_EQ(done->result, spi::ValidationResult::ok);
}

TEST_F(KeptRequest, AnotherRequest_GetsAnotherKey) {
  const auto request = two.request();
  ASSERT_OK(request);
  const auto first = two.reply(*request->message);
  ASSERT_OK(first);
  ASSERT_OK((*two.high.plugin)->return_identity_handle(two.low_at_high));
  two.low.plugin->clock.advance(KeptRequests::kLife + 1s);
  meet_again();
  const auto again = two.high.discover(two.low);
  ASSERT_OK(again);
  two.low_at_high = again->handle;
  const auto other = two.request();
  ASSERT_OK(other);
  EXPECT_NE(*other->message, *request->message);
  const auto second = two.reply(*other->message);
  ASSERT_OK(second);
  EXPECT_NE(field(*second->message, "dh2"), field(*first->message, "dh2"));
}

// Otherwise the recorded messages of one session would be valid in the next one.
TEST_F(KeptRequest, OneChallenge_NeverServesTwoSessions) {
  const auto request = two.request();
  ASSERT_OK(request);
  const auto first = two.reply(*request->message);
  ASSERT_OK(first);
  pairing.expect_finish(*request, *first);
  ASSERT_OK((*two.high.plugin)->return_identity_handle(two.low_at_high));
  const auto again = two.high.discover(two.low);
  ASSERT_OK(again);
  two.low_at_high = again->handle;
  const auto second = two.reply(*request->message);
  ASSERT_OK(second);
  EXPECT_NE(field(*second->message, "challenge2"), field(*first->message, "challenge2"));
}

}  // namespace
}  // namespace ddssec::authentication
