// Only payloads are protected, and an attacker sends an overheard payload again as the end of its
// instance.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Participant a writes and b reads. The attacker hears the last DATA of a's writer, and changes
// what surrounds its payload.
struct ForgedEnds : ::testing::TestWithParam<ProtectionKind> {
  ForgedEnds() : pair({.data = GetParam()}) {
    EXPECT_TRUE(pair.match());
    pair.world.run(100);
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &pair.a) hear(datagram);
      return one(std::move(datagram));
    };
  }
  void hear(BytesView datagram) {
    each_data(datagram, [&](const Data& data) {
      if (data.writer != pair.writer.entity || data.payload.empty()) return;
      payload = to_bytes(data.payload);
      qos = data.inline_qos;
      number = data.sequence_number;
    });
  }
  void forge(const StatusInfo& status, PayloadKind kind) {
    auto changed = qos;
    changed.status = status;
    // A refused number stays free, so each forgery would be the next change.
    pair.b->receive(forged(pair.a->prefix(), Data{pair.reader.entity, pair.writer.entity,
                                                  number.next(), changed, kind, payload}),
                    pair.world.now, *Locator::parse("127.0.0.1", 7999));
  }
  // Writes an end with a's writer.
  void end(const StatusInfo& status, std::size_t size = 8) {
    Change change;
    change.status = status;
    change.is_key_only = true;
    change.key_hash.emplace().fill(1);
    change.payload = testing::payload(size);
    pair.a->local_endpoints().writer(pair.writer)->write(std::move(change), pair.world.now);
    pair.world.run(20);
  }
  const std::vector<Change>& received() const { return pair.b.listener.changes; }

  Pair pair;
  Bytes payload;
  InlineQos qos;
  SequenceNumber number;
};

TEST_P(ForgedEnds, WithThePayloadOfASample_AreDropped) {
  pair.write();
  pair.world.run(20);
  ASSERT_EQ(received().size(), 1u);
  for (const auto kind : {PayloadKind::data, PayloadKind::key})
    for (const auto& status :
         {StatusInfo{true, false}, StatusInfo{false, true}, StatusInfo{true, true}})
      forge(status, kind);
  EXPECT_EQ(received().size(), 1u);
  EXPECT_TRUE(pair.b.events.has(Code::rtps_protection_missing)) << pair.b.events.text();
}

// An unregister is no dispose, the key of an end is no sample, and without its status an end is
// none.
TEST_P(ForgedEnds, WithThePayloadOfAnotherEnd_AreDropped) {
  end({.unregistered = true});
  ASSERT_EQ(received().size(), 1u);
  forge({.disposed = true}, PayloadKind::key);
  forge({.unregistered = true}, PayloadKind::data);
  forge({}, PayloadKind::data);
  forge({}, PayloadKind::key);
  EXPECT_EQ(received().size(), 1u);
}

TEST_P(ForgedEnds, TrueEnds_Count) {
  end({.disposed = true});
  end({.unregistered = true});
  end({.disposed = true, .unregistered = true});
  ASSERT_EQ(received().size(), 3u);
  for (const auto& change : received()) {
    EXPECT_FALSE(change.is_alive());
    EXPECT_TRUE(change.is_key_only);
    EXPECT_EQ(to_bytes(change.payload.view()), to_bytes(testing::payload(8).view()))
        << "without the mark";
  }
  EXPECT_TRUE(pair.b.events.is_quiet()) << pair.b.events.text();
}

TEST_P(ForgedEnds, TrueEnds_CountInFragments) {
  end({.disposed = true}, 200'000);
  pair.world.run(100);
  ASSERT_EQ(received().size(), 1u);
  EXPECT_TRUE(received()[0].status.disposed);
  EXPECT_EQ(to_bytes(received()[0].payload.view()), to_bytes(testing::payload(200'000).view()));
  pair.write(200'000);
  EXPECT_TRUE(pair.world.run_until([&] { return received().size() == 2; }, 300));
}

// All fragments of the sample say that it ends its instance.
TEST_P(ForgedEnds, InTheFragmentsOfASample_AreDropped) {
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    auto reader = MessageReader::open(datagram);
    const auto view = reader ? reader->next() : fail(Code::truncated);
    for (auto at = view; &from == &pair.a && at && *at; at = reader->next()) {
      if ((*at)->id != SubmessageId::data_frag) continue;
      auto frag = read_data_frag(**at).value();
      frag.inline_qos.status.disposed = true;
      frag.payload = frag.encoded;  // the payload as it was sent
      return one(forged(pair.a->prefix(), frag));
    }
    return one(std::move(datagram));
  };
  pair.write(200'000);
  pair.world.run(100);
  EXPECT_TRUE(received().empty());
  pair.world.filter = {};
  ASSERT_TRUE(pair.world.run_until([&] { return received().size() == 1; }, 300));
  EXPECT_TRUE(received()[0].is_alive());
}

// The peer has an earlier version or is of another vendor. The remedy is to protect metadata, too.
TEST_P(ForgedEnds, EndsOfAPeerThatDoesNotMarkThem_Count) {
  ParticipantAccess::peer(*pair.b.participant, pair.a->prefix()).marks_ends = false;
  pair.write();
  end({.disposed = true});
  ASSERT_EQ(received().size(), 2u);
  forge({.disposed = true, .unregistered = true}, PayloadKind::key);
  EXPECT_EQ(received().size(), 3u);
}

INSTANTIATE_TEST_SUITE_P(Payload, ForgedEnds,
                         ::testing::Values(ProtectionKind::sign, ProtectionKind::encrypt),
                         [](const auto& info) {
                           return info.param == ProtectionKind::sign ? "signed" : "encrypted";
                         });

}  // namespace
}  // namespace ddssec::rtps
