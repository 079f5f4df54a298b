// Replies that must be refused, each with exactly its code, and without harm to the honest one.
#include "plugins/authentication/handshake_reply.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/forgeries.hpp"

namespace ddssec::authentication::forgeries {
namespace {

std::vector<Forgery> of_reply() {
  auto all = of_credentials();
  for (const auto* name : {"dh2", "challenge1", "challenge2", "signature"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 2049));
  }
  for (const auto* name : {"dh1", "hash_c1", "hash_c2", "challenge1"})
    all.push_back(flips(name, Code::token_field_differs));
  for (const auto* name : {"challenge2", "signature"})
    all.push_back(flips(name, Code::signature_invalid));
  all.push_back(unhashed(flips("c.perm", Code::signature_invalid)));
  all.push_back(flips("dh2", Code::public_key_not_in_group));
  all.push_back(sets("OtherKeyAgreement", "c.kagree_algo", bytes("DH+MODP-2048-256"),
                     Code::key_agreement_algorithm_changed));
  all.push_back(unhashed(
      sets("OtherName", "c.kagree_algo", bytes("ECDHE-CEUM+P256"), Code::signature_invalid)));
  all.push_back(unhashed(sets("OtherSignatureName", "c.dsign_algo", bytes("RSASSA-PSS-SHA256"),
                              Code::signature_invalid)));
  all.push_back({"AsRequest", Code::token_field_length, [](Token t) {
                   return with(renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Req"), "dh1", {});
                 }});
  return all;
}

class ForgedReply : public testing::TestWithParam<Forgery> {};

INSTANTIATE_TEST_SUITE_P(Each, ForgedReply, testing::ValuesIn(of_reply()), kName);

TEST_P(ForgedReply, ForgedReply_IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  auto& events = pairing.two.low.plugin->events.all;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  const auto refused =
      pairing.two.process_at_lower_guid(request->handle, GetParam().change(*reply->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].error.code(), GetParam().code);
  EXPECT_CODE((*pairing.two.low.plugin)->shared_secret(request->handle), handshake_not_finished);
  pairing.expect_finish(*request, *reply);
}

TEST(FlippedBit, BitFlippedAnywhereInAReply_IsRefused) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  for (const auto& property : reply->message->binary_properties) {
    const std::size_t step = property.value.size() > 200 ? 7 : 1;
    for (std::size_t at = 0; at < property.value.size(); at += step)
      EXPECT_FALSE(pairing.two.process_at_lower_guid(
          request->handle, with(*reply->message, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  }
  pairing.expect_finish(*request, *reply);
}

// Without the hashes, only the signature can show the change.
TEST(FlippedBit, BitFlippedInAReplyWithoutOptionalFields_IsRefused) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  const Token bare = without(without(without(*reply->message, "hash_c1"), "hash_c2"), "dh1");
  for (const auto& property : bare.binary_properties) {
    const std::size_t step = property.value.size() > 200 ? 7 : 1;
    for (std::size_t at = 0; at < property.value.size(); at += step)
      EXPECT_FALSE(pairing.two.process_at_lower_guid(
          request->handle, with(bare, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  }
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, bare);
  ASSERT_OK(final_message);
  ASSERT_OK(pairing.two.process_at_higher_guid(reply->handle, *final_message->message));
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
