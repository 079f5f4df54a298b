// Where neither discovery nor messages are protected, nothing protects DCPSParticipantsSecure. A
// stranger says there in a peer's name that the peer has left, or that its lease is very short.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

std::vector<Rules> governances() {
  return {{.metadata = kEncrypt, .data = kEncrypt},
          {.data = kEncrypt},
          {.liveliness = kEncrypt, .metadata = kEncrypt},
          {.discovery = kEncrypt, .metadata = kEncrypt},
          everything(kEncrypt)};
}

struct ForgedLeave : ::testing::TestWithParam<Rules> {
  Pair pair{GetParam()};
  // The number of the next announcement is seen on the network.
  SequenceNumber next() {
    return ParticipantAccess::local_endpoints(*pair.a.participant)
        .builtin()
        .find_reader(kParticipantsSecureReader)
        ->writer({pair.b->prefix(), kParticipantsSecureWriter})
        ->next();
  }
  void send(const Data& data) {
    pair.a->receive(forged(pair.b->prefix(), data), pair.world.now,
                    *Locator::parse("127.0.0.9", 0));
  }
  void expect_still_there() {
    EXPECT_TRUE(pair.a.knows(pair.b));
    pair.world.run(5);
    EXPECT_TRUE(pair.a.knows(pair.b));
    EXPECT_EQ(pair.a.listener.unmatched, 0);
    EXPECT_EQ(pair.a.listener.matched, 1);
    pair.world.run(6000);
    EXPECT_EQ(pair.a.events.count(Code::rtps_peer_authenticated), 1) << pair.a.events.text();
  }
};

TEST_P(ForgedLeave, Dispose_EndsNoSession) {
  ASSERT_TRUE(pair.match());
  pair.world.run(200);
  Data data{kParticipantsSecureReader, kParticipantsSecureWriter, next()};
  const Guid guid{pair.b->prefix(), kEntityIdParticipant};
  Bytes buffer(64);
  SpanWriter out(buffer);
  write_participant_key(out, guid);
  data.kind = PayloadKind::key;
  data.payload = out.view();
  data.inline_qos.key_hash = guid.octets();
  data.inline_qos.status = {.disposed = true, .unregistered = true};
  send(data);
  expect_still_there();
}

TEST_P(ForgedLeave, ShortLease_EndsNoSession) {
  ASSERT_TRUE(pair.match());
  pair.world.run(200);
  auto own = secured_data(pair.b->prefix(), 7002);
  own.vendor = kVendorDdssec;
  own.lease_duration = Duration{{0, 1}};
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, own);
  Data data{kParticipantsSecureReader, kParticipantsSecureWriter, next()};
  data.payload = out.view();
  data.inline_qos.key_hash = own.guid.octets();
  send(data);
  expect_still_there();
}

// One datagram in two seconds keeps the two from talking.
TEST_P(ForgedLeave, DisposeAgainAndAgain_KeepsNoPairApart) {
  ASSERT_TRUE(pair.match());
  pair.world.run(200);
  int matched = 0;
  for (int i = 0; i < 600; ++i) {
    const auto* writer = ParticipantAccess::local_endpoints(*pair.a.participant)
                             .builtin()
                             .find_reader(kParticipantsSecureReader)
                             ->writer({pair.b->prefix(), kParticipantsSecureWriter});
    if (i % 20 == 0 && writer != nullptr) {
      Data data{kParticipantsSecureReader, kParticipantsSecureWriter, writer->next()};
      const Guid guid{pair.b->prefix(), kEntityIdParticipant};
      data.kind = PayloadKind::key;
      Bytes buffer(64);
      SpanWriter out(buffer);
      write_participant_key(out, guid);
      data.payload = out.view();
      data.inline_qos.key_hash = guid.octets();
      data.inline_qos.status = {.disposed = true, .unregistered = true};
      send(data);
    }
    pair.world.run(10);
    matched += pair.a.listener.matched == 1 && pair.b.listener.matched == 1 ? 1 : 0;
  }
  EXPECT_EQ(matched, 600) << "tenths of a second of one minute";
}

// What a participant sends when it leaves is recorded, and sent again when it has come back.
TEST_P(ForgedLeave, RecordingOfAnEarlierSession_EndsNoSession) {
  ASSERT_TRUE(pair.match());
  pair.world.run(200);
  pair.b->leave();
  const auto recorded = pair.b.post.sent;
  ASSERT_FALSE(recorded.empty());
  pair.b->change_own({}, pair.world.now);  // announces itself again: it does not leave after all
  pair.world.run(1);
  ASSERT_FALSE(pair.a.knows(pair.b));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.knows(pair.b); }, 3000));
  pair.world.run(200);
  for (const auto& [port, datagram] : recorded)
    pair.a->receive(datagram, pair.world.now, *Locator::parse("127.0.0.9", 0));
  pair.world.run(10);
  EXPECT_TRUE(pair.a.knows(pair.b));
  EXPECT_EQ(pair.a.events.count(Code::rtps_peer_authenticated), 2) << pair.a.events.text();
}

INSTANTIATE_TEST_SUITE_P(Governances, ForgedLeave, ::testing::ValuesIn(governances()),
                         [](const auto& info) { return std::to_string(info.index); });

}  // namespace
}  // namespace ddssec::rtps
