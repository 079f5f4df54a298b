// What a stock reader says to one participant opens at all others, because it has one key for all
// of them, and INFO_DST is not protected. An attacker on the path sends it to another one (T41 of
// docs/attacks.md).
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/acknack.hpp"
#include "wire/nack_frag.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Participant a announces writers to b. The SEDP reader of b has far higher counts with another
// participant.
struct RedirectedRequests : ::testing::Test {
  static constexpr Rules kRules{.discovery = kEncrypt, .liveliness = kEncrypt};
  static constexpr std::int32_t kFarAhead = 1000;
  RedirectedRequests() : pair(kRules) {
    EXPECT_TRUE(pair.match());
    pair.world.run(100);
  }
  // Sends to a what b said to another participant.
  template <class Message>
  void redirect(const Message& message) {
    Bytes plain(256), protected_one(512);
    SpanWriter out(plain);
    write(out, message);
    const auto& core = pair.b->remote_participants().core();
    const auto size = core.security->keyring().protect_submessage(
        reader, {pair.a->prefix(), writer}, out.view(), protected_one);
    ASSERT_TRUE(size);
    auto datagram = forged(pair.b->prefix());
    datagram.insert(datagram.end(), protected_one.begin(),
                    protected_one.begin() + static_cast<std::ptrdiff_t>(*size));
    pair.a->receive(datagram, pair.world.now, *Locator::parse("127.0.0.1", 7999));
  }
  AckNack acknack(std::int64_t base, std::int32_t count) const {
    return {reader, writer, SequenceNumberSet(SequenceNumber{base}), count, true};
  }
  // Participant a announces a further writer, and at first nothing of this arrives.
  void announce_into_the_void() {
    pair.world.attack = [](World::Traffic& traffic) { traffic.clear(); };
    static_cast<void>(
        pair.a->create_writer(square(default_writer_qos()), pair.a.listener, pair.world.now));
    pair.world.run(1);
  }
  bool is_found(std::chrono::seconds within) {
    return pair.world.run_until([&] { return pair.b.listener.matched == 2; },
                                static_cast<int>(within / 10ms));
  }
  const ReaderProxy& proxy() {
    return *ParticipantAccess::local_endpoints(*pair.a.participant)
                .builtin()
                .writer(BuiltinTopic::publications_secure)
                .readers()
                .find({pair.b->prefix(), reader});
  }

  const EntityId reader = kPublicationsSecureReader, writer = kPublicationsSecureWriter;
  Pair pair;
};

// Otherwise all requests of the reader would count as repetitions, until its counts have reached
// the higher ones.
TEST_F(RedirectedRequests, WithHighCounts_HideNoLaterRequest) {
  redirect(acknack(1, kFarAhead));
  announce_into_the_void();
  pair.world.attack = {};
  EXPECT_TRUE(is_found(3s));
}

TEST_F(RedirectedRequests, FragmentRequests_HideNoLaterOnes) {
  NackFrag request{reader, writer, {1}, FragmentNumberSet(FragmentNumber{1}), kFarAhead};
  redirect(request);
  const auto taken = proxy().nack_frags.taken();
  request.count = 1;
  redirect(request);
  EXPECT_EQ(proxy().nack_frags.taken(), taken + 1);
}

TEST_F(RedirectedRequests, RequestsOfAPeerThatIsGone_AreNoSignOfLife) {
  pair.world.nodes = {&pair.a};
  const auto lease =
      pair.a->remote_participants().all().begin()->second.data.lease_duration.to_nanoseconds();
  for (int i = 0; i < lease / 1s + 1; ++i) {
    if (i < lease / 2s) {
      ASSERT_TRUE(pair.a.knows(pair.b)) << i;
    }
    if (pair.a.knows(pair.b)) redirect(acknack(1, kFarAhead + i));
    pair.world.run(100);
  }
  EXPECT_EQ(pair.a->remote_participants().size(), 0u);
}

// Participant a believes that b has the announcement, and b does not know of it.
TEST_F(RedirectedRequests, AcknowledgmentOfALostSample_IsHealedByTheNextOffer) {
  announce_into_the_void();
  redirect(acknack(3, kFarAhead));
  pair.world.run(10);
  pair.world.attack = {};
  pair.world.run(300);
  ASSERT_EQ(pair.b.listener.matched, 1);
  EXPECT_TRUE(is_found(ClearAnnouncements::kOfferPeriod / 1s * 1s + 2s));
}

}  // namespace
}  // namespace ddssec::rtps
