// How often handshakes are tried while messages do not arrive.
#include "rtps/security/handshakes.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// An attacker that loses or forges messages for a while cannot keep two participants apart for
// ever.
TEST(Handshake, AnyTimeWithoutMessages_IsSurvived) {
  for (const auto seconds_without : {105, 250, 700}) {
    Pair pair({});
    // Announcements arrive, and handshake messages do not.
    bool lost = true;
    pair.world.filter = [&](const Node&, Bytes datagram) {
      if (!lost) return one(std::move(datagram));
      auto reader = MessageReader::open(datagram);
      while (const auto view = *reader->next())
        if (view->id == SubmessageId::data && read_data(*view)->writer != kSpdpWriter)
          return std::vector<Bytes>{};
      return one(std::move(datagram));
    };
    pair.world.run(100 * seconds_without);
    for (const auto* node : {&pair.a, &pair.b})
      EXPECT_EQ(node->events.count(Code::rtps_authentication_timeout), 1) << seconds_without;
    EXPECT_FALSE(pair.a.knows(pair.b));
    lost = false;
    const auto wait = PeerHandshake::kSignPause + seconds(4);  // until the next announcement
    EXPECT_TRUE(pair.world.run_until([&] { return know_each_other(pair); },
                                     static_cast<int>(wait / milliseconds(10))))
        << seconds_without;
  }
}

bool is_stateless(BytesView datagram) {
  auto reader = MessageReader::open(datagram);
  while (const auto view = *reader->next())
    if (view->id == SubmessageId::data && read_data(*view)->writer == kStatelessMessageWriter)
      return true;
  return false;
}

// The slow pace costs little: each side tries once in eight seconds, and one of them sends two
// messages then.
TEST(Handshake, APeerThatOnlyAnnouncesItself_IsAskedRarelyAfterAWhile) {
  Pair pair({});
  int asked = 0;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    if (!is_stateless(datagram)) return one(std::move(datagram));
    ++asked;
    return std::vector<Bytes>{};
  };
  pair.world.run(10'000);
  asked = 0;
  pair.world.run(100'000);
  EXPECT_GT(asked, 0);
  EXPECT_LE(asked, 3 * (1000s / PeerHandshake::kSignPause));
}

}  // namespace
}  // namespace ddssec::rtps
