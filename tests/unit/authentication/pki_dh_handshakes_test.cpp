// Messages in a wrong state, repeated messages, and challenges that were announced before.
#include "plugins/authentication/pki_dh.hpp"
#include "tests/support/hostile_pki.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/forgeries.hpp"

namespace ddssec::authentication::forgeries {
namespace {

// ---- wrong state

TEST(WrongState, MessageInTheWrongState_IsRefused) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  const auto req2 = Pairing().two.request();
  // The initiator is established.
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, *request->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, *final_message->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle,
                                                with(*reply->message, "signature", Bytes(70))),
              unexpected_message);
  // The replier waits for a final message.
  EXPECT_CODE(pairing.two.process_at_higher_guid(reply->handle, *reply->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_higher_guid(reply->handle, *req2->message),
              unexpected_message);
  ASSERT_OK(pairing.two.process_at_higher_guid(reply->handle, *final_message->message));
  // The replier is established.
  EXPECT_CODE(pairing.two.process_at_higher_guid(reply->handle, *request->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_higher_guid(reply->handle, *reply->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_higher_guid(
                  reply->handle, with(*final_message->message, "signature", Bytes(70))),
              unexpected_message);
  EXPECT_CODE(pairing.two.reply(*request->message), unexpected_message);
}

TEST(WrongState, AnInitiatorWaitingForAReply_TakesNothingElse) {
  Pairing pairing, other;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto req2 = other.two.request();
  const auto rep2 = other.two.reply(*req2->message);
  const auto fin2 = other.two.process_at_lower_guid(req2->handle, *rep2->message);
  ASSERT_OK(fin2);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, *request->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, *fin2->message),
              unexpected_message);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, {"DDS:Auth:PKI-DH:1.0"}),
              token_class_wrong);
  EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, {"DDS:Auth:PKI-DH:1.0+AuthReq"}),
              token_class_wrong);
  pairing.expect_finish(*request, *reply);
}

TEST(WrongState, Roles_AreDecidedByTheGuids) {
  Pairing pairing;
  auto& two = pairing.two;
  EXPECT_CODE(
      (*two.high.plugin)->begin_handshake_request(two.high.handle, two.low_at_high, two.high.data),
      handshake_role_wrong);
  const auto request = two.request();
  EXPECT_CODE(
      (*two.low.plugin)
          ->begin_handshake_reply(*request->message, two.high_at_low, two.low.handle, two.low.data),
      handshake_role_wrong);
}

TEST(WrongState, OwnParticipantData_MustFit) {
  Pairing pairing;
  auto& two = pairing.two;
  for (const std::size_t size : {0u, 64u * 1024 + 1})
    EXPECT_CODE(
        (*two.low.plugin)->begin_handshake_request(two.low.handle, two.high_at_low, Bytes(size)),
        token_field_length);
  EXPECT_CODE((*two.high.plugin)->begin_handshake_reply({}, two.low_at_high, two.high.handle, {}),
              token_field_length);
}

// ---- repetitions

TEST(Repetition, RepeatedMessage_GetsTheSameAnswerWithoutNewKeys) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto again = pairing.two.request();
  ASSERT_OK(again);
  EXPECT_EQ(again->handle, request->handle);
  EXPECT_EQ(again->message, request->message);
  const auto reply = pairing.two.reply(*request->message);
  const auto rep_again = pairing.two.reply(*request->message);
  ASSERT_OK(rep_again);
  EXPECT_EQ(rep_again->handle, reply->handle);
  EXPECT_EQ(rep_again->message, reply->message);
  const auto by_process = pairing.two.process_at_higher_guid(reply->handle, *request->message);
  ASSERT_OK(by_process);
  EXPECT_EQ(by_process->message, reply->message);
  EXPECT_EQ(by_process->result, ValidationResult::pending_handshake_message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  const auto fin_again = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(fin_again);
  EXPECT_EQ(fin_again->message, final_message->message);
  EXPECT_EQ(fin_again->result, ValidationResult::ok_final_message);
  ASSERT_OK(pairing.two.process_at_higher_guid(reply->handle, *final_message->message));
  const auto end_again = pairing.two.process_at_higher_guid(reply->handle, *final_message->message);
  ASSERT_OK(end_again);
  EXPECT_EQ(end_again->result, ValidationResult::ok);
}

// ---- announced challenges

TEST(FutureChallenge, AnnouncedChallenge_BindsTheHandshake) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto of_low = two.low.discover(two.high);
  const auto of_high = two.high.discover(two.low);
  ASSERT_TRUE(of_low->local_auth_request && of_high->local_auth_request);
  const auto told_low = two.low.discover(two.high, of_high->local_auth_request);
  const auto told_high = two.high.discover(two.low, of_low->local_auth_request);
  ASSERT_OK(told_low);
  ASSERT_OK(told_high);
  EXPECT_FALSE(told_low->local_auth_request);
  EXPECT_EQ(told_low->handle, of_low->handle);
  const auto request = two.request();
  EXPECT_EQ(field(*request->message, "challenge1"),
            field(*of_low->local_auth_request, "future_challenge"));
  pairing.expect_success();
}

TEST(FutureChallenge, AnotherOne_IsRefusedInBothRoles) {
  Pairing pairing;
  auto& two = pairing.two;
  const Token forged{.class_id = "DDS:Auth:PKI-DH:1.0+AuthReq",
                     .binary_properties = {{"future_challenge", Bytes(32, 9)}}};
  ASSERT_OK(two.high.discover(two.low, forged));
  const auto request = two.request();
  EXPECT_CODE(two.reply(*request->message), challenge_not_announced);
  // After the honest announcement the handshake succeeds.
  ASSERT_OK(two.high.discover(two.low, two.low.discover(two.high)->local_auth_request));
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  ASSERT_OK(two.low.discover(two.high, forged));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, *reply->message), challenge_not_announced);
  ASSERT_OK(two.low.discover(two.high, two.high.discover(two.low)->local_auth_request));
  pairing.expect_finish(*request, *reply);
}

TEST(FutureChallenge, AMalformedOne_IsRefused) {
  Pairing pairing;
  EXPECT_CODE(pairing.a.discover(pairing.b, Token{"DDS:Auth:PKI-DH:1.0+AuthReq"}),
              token_field_missing);
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
