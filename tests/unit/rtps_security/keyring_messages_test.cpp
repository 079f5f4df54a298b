// Whole messages: their protection, and in whose name their submessages are sent.
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/keyrings.hpp"
#include "wire/acknack.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps::keyrings {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;

TEST(KeyringTransform, InfoSourceInAClearMessage_GivesNoRights) {
  Protected pair({.metadata = kSign});
  InfoSource source;
  source.source.prefix = pair.a->prefix();
  pair.b->receive(forged(GuidPrefix::from(Bytes(12, 9)), source, pair.data(1)), pair.world.now);
  EXPECT_TRUE(pair.b.listener.changes.empty());
  pair.write();
  pair.world.run(200);
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
}

TEST(KeyringTransform, AProtectedMessageWithOneOctetChangedOrCut_IsNothing) {
  for (const auto& rules : {everything(kSign), everything(kEncrypt),
                            everything(ProtectionKind::encrypt_with_origin_authentication)}) {
    Protected pair(rules);
    pair.world.run(200);
    pair.a.post.sent.clear();
    pair.write();
    ASSERT_FALSE(pair.a.post.sent.empty());
    const auto sent = pair.a.post.sent.front().second;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      auto broken = sent;
      broken[i] ^= 0x40;
      pair.b->receive(broken, pair.world.now);
      pair.b->receive(BytesView(sent).first(i), pair.world.now);
    }
    EXPECT_TRUE(pair.b.listener.changes.empty());
    pair.b->receive(sent, pair.world.now);
    EXPECT_EQ(pair.b.listener.changes.size(), 1u);
  }
}

}  // namespace
}  // namespace ddssec::rtps::keyrings
