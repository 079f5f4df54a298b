// Requests that must be refused, each with exactly its code, and without harm to the honest one.
#include "plugins/authentication/handshake_request.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/forgeries.hpp"

namespace ddssec::authentication::forgeries {
namespace {

Bytes off_curve() {
  Bytes point(65, 1);
  point[0] = 4;
  return point;
}

std::vector<Forgery> of_request() {
  auto all = of_credentials();
  for (const auto* name : {"dh1", "challenge1"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 1025));
  }
  all.push_back(resizes("challenge1", 31));
  all.push_back(resizes("challenge1", 33));
  all.push_back(resizes("hash_c1", 31));
  all.push_back(repeats("hash_c1"));
  all.push_back(flips("hash_c1", Code::token_field_differs));
  all.push_back(sets("ShortPoint", "dh1", Bytes(64, 4), Code::public_key_malformed));
  all.push_back(sets("PointOffTheCurve", "dh1", off_curve(), Code::public_key_not_in_group));
  all.push_back({"OtherClass", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:Other:1.0+Req"); }});
  all.push_back({"AsReply", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Reply"); }});
  return all;
}

class ForgedRequest : public testing::TestWithParam<Forgery> {};

INSTANTIATE_TEST_SUITE_P(Each, ForgedRequest, testing::ValuesIn(of_request()), kName);

TEST_P(ForgedRequest, ForgedRequest_IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  auto& events = pairing.two.high.plugin->events.all;
  const auto request = pairing.two.request();
  ASSERT_OK(request);
  const auto refused = pairing.two.reply(GetParam().change(*request->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].error.code(), GetParam().code);
  EXPECT_EQ(events[0].guid, pairing.two.low.guid.to_string());
  EXPECT_FALSE(events[0].is_returned);
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  pairing.expect_finish(*request, *reply);
}

// A request is not signed, so a change of it must be noticed in the reply.
TEST(FlippedBit, BitFlippedInAnAnsweredRequest_MakesTheInitiatorRefuse) {
  for (const auto* name : {"c.perm", "challenge1"}) {
    Pairing pairing;
    const auto request = pairing.two.request();
    Token changed = without(*request->message, "hash_c1");
    changed = with(changed, name, flipped(field(changed, name), 0));
    const auto reply = pairing.two.reply(changed);
    ASSERT_OK(reply);
    const auto refused = pairing.two.process_at_lower_guid(request->handle, *reply->message);
    EXPECT_CODE(refused, token_field_differs);
    const auto honest = pairing.two.reply(*request->message);
    ASSERT_OK(honest);
    pairing.expect_finish(*request, *honest);
  }
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
