// A local participant that is cut off: nothing is encoded or decoded for it any more.
#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

const Bytes kPayload(8, 1), kData = data_submessage(16), kMessage = rtps_message({kData});

struct CutOff : ::testing::Test {
  TwoSides two{ProtectionKind::encrypt};
  WriterToReader all =
      two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::encrypt));
  Bytes payload = encode_payload(two, all, kPayload).value();
  Bytes submessage = encode_submessage(two, all, kData).value();
  Bytes reply = encode_reply(two, all, kData).value();
  Bytes message = encode_message(two, kMessage).value();
};

TEST_F(CutOff, CutOffSender_EncodesNothing) {
  two.a.factory().cut_off(two.a.participant);
  EXPECT_EQ(code_of(encode_payload(two, all, kPayload)), Code::identity_ended);
  EXPECT_EQ(code_of(encode_submessage(two, all, kData)), Code::identity_ended);
  EXPECT_EQ(code_of(encode_message(two, kMessage)), Code::identity_ended);
  EXPECT_EQ(code_of(decode_reply(two, all, reply)), Code::identity_ended);
  EXPECT_TRUE(decode_payload(two, all, payload)) << "the other side is not";
}

TEST_F(CutOff, CutOffReceiver_DecodesNothing) {
  two.b.factory().cut_off(two.b.participant);
  EXPECT_EQ(code_of(decode_payload(two, all, payload)), Code::identity_ended);
  EXPECT_EQ(code_of(decode_submessage(two, all, submessage)), Code::identity_ended);
  EXPECT_EQ(code_of(decode_message(two, message)), Code::identity_ended);
  EXPECT_EQ(code_of(encode_reply(two, all, kData)), Code::identity_ended);
}

TEST_F(CutOff, RemoteOrUnknownHandle_IsLeftAlone) {
  two.a.factory().cut_off(two.a.remote);
  two.a.factory().cut_off({});
  EXPECT_TRUE(encode_message(two, kMessage));
}

}  // namespace
}  // namespace ddssec::cryptography
