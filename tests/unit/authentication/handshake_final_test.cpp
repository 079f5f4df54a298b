// Final messages that must be refused, each with exactly its code, and without harm to the honest
// one.
#include "plugins/authentication/handshake_final.hpp"

#include <gmock/gmock.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/forgeries.hpp"

namespace ddssec::authentication::forgeries {
namespace {

std::vector<Forgery> of_final() {
  std::vector<Forgery> all;
  for (const auto* name : {"challenge1", "challenge2", "signature"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 2049));
  }
  for (const auto* name : {"challenge1", "challenge2", "dh1", "dh2", "hash_c1", "hash_c2"})
    all.push_back(flips(name, Code::token_field_differs));
  all.push_back(flips("signature", Code::signature_invalid));
  all.push_back({"OtherClass", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Finale"); }});
  return all;
}

class ForgedFinal : public testing::TestWithParam<Forgery> {};

INSTANTIATE_TEST_SUITE_P(Each, ForgedFinal, testing::ValuesIn(of_final()), kName);

TEST_P(ForgedFinal, ForgedFinal_IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  const auto refused =
      pairing.two.process_at_higher_guid(reply->handle, GetParam().change(*final_message->message));
  EXPECT_EQ(test::code_of(refused), GetParam().code);
  EXPECT_CODE((*pairing.two.high.plugin)->shared_secret(reply->handle), handshake_not_finished);
  EXPECT_CODE((*pairing.two.high.plugin)->authenticated_peer_credential_token(reply->handle),
              handshake_not_finished);
  ASSERT_OK(pairing.two.process_at_higher_guid(reply->handle, *final_message->message));
}

TEST(FlippedBit, BitFlippedAnywhereInAFinal_IsRefused) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  for (const auto& property : final_message->message->binary_properties)
    for (std::size_t at = 0; at < property.value.size(); ++at)
      EXPECT_THAT(test::code_of(pairing.two.process_at_higher_guid(
                      reply->handle,
                      with(*final_message->message, property.name, flipped(property.value, at)))),
                  testing::AnyOf(Code::token_field_differs, Code::signature_invalid))
          << property.name << " " << at;
  ASSERT_OK(pairing.two.process_at_higher_guid(reply->handle, *final_message->message));
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
