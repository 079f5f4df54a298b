// INFO_REPLY, in both forms.
#include "wire/info_reply.hpp"

#include <gmock/gmock.h>

#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

TEST(InfoReply, InfoReply_RoundTrips) {
  expect_round_trip(InfoReply{*Locator::parse("10.0.0.1", 7400), {}}, read_info_reply);
  expect_round_trip(InfoReply{*Locator::parse("::1", 1), *Locator::parse("239.255.0.1", 2)},
                    read_info_reply);
}

// Found by fuzzing: an address without a kind of transport counts as none.
TEST(InfoReply, AnInfoReplyToALocatorWithoutAKind_IsToNone) {
  Bytes octets = {0x0f, 1, 28, 0, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};
  octets.resize(32, 0xff);
  const auto view = MessageReader::over_submessages({}, octets).next();
  ASSERT_TRUE(view && *view);
  EXPECT_EQ(read_info_reply(**view), InfoReply{});
}

TEST(InfoReply, InfoReplyIp4_IsRead) {
  const Bytes body = {1, 0, 0, 127, 0xe8, 0x1c, 0, 0};  // little endian 127.0.0.1:7400
  SubmessageView view{SubmessageId::info_reply_ip4, 1, body, body};
  EXPECT_EQ(read_info_reply_ip4(view)->unicast, Locator::udp_v4({127, 0, 0, 1}, 7400));
}

}  // namespace
}  // namespace ddssec::rtps::submessages
