// Final messages that must be refused, each with exactly its code, and without harm to the honest
// one.
#include "plugins/authentication/handshake_final.hpp"

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
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  const auto refused = pairing.two.at_high(rep->handle, GetParam().change(*fin->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  EXPECT_CODE((*pairing.two.high.engine)->shared_secret(rep->handle), handshake_not_finished);
  EXPECT_CODE((*pairing.two.high.engine)->authenticated_peer_credential_token(rep->handle),
              handshake_not_finished);
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
}

TEST(FlippedBit, BitFlippedAnywhereInAFinal_IsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  for (const auto& property : fin->message->binary_properties)
    for (std::size_t at = 0; at < property.value.size(); ++at)
      EXPECT_FALSE(pairing.two.at_high(
          rep->handle, with(*fin->message, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
