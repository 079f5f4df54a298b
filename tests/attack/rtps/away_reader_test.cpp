// Bob has two readers of alice's writer. The older one is in another partition while alice revises
// her keys, because carol is revoked. It does not get the new keys, and is matched no more. The
// other reader must hear alice under the new keys, and must not hear carol.
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/attack/rtps/stolen_keys.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

Rules in_partitions(Rules rules) {
  rules.partitions = "*";
  return revising(rules);
}

Guid reader_of_bob(Trio& trio) {
  const auto readers = trio.a->local_endpoints().matched(trio.writer);
  return *std::ranges::find(readers, trio.b->prefix(), &Guid::prefix);
}

void move(Trio& trio, const Guid& reader, std::vector<std::string> partition) {
  auto qos = trio.b->local_endpoints().find(reader.entity)->qos;
  qos.partition = std::move(partition);
  ASSERT_TRUE(trio.b->change_qos(reader, qos, trio.world.now));
}

void until_former_keys_have_ended(Trio& trio) {
  for (int second = 0; second < 13; ++second) {
    for (auto* node : trio.world.nodes) node->clock.advance(1s);
    trio.world.run(100);
  }
}

class TwoReadersOfBob : public ::testing::TestWithParam<Rules> {
 protected:
  // Matches all, sends the older of bob's readers away and revokes carol.
  void begin() {
    ASSERT_TRUE(trio.match()) << trio.text();
    older = reader_of_bob(trio);
    second_qos = trio.b->local_endpoints().find(older.entity)->qos;
    made = trio.b->create_reader(square(second_qos), second, trio.world.now);
    ASSERT_TRUE(made);
    ASSERT_TRUE(trio.world.run_until([&] { return second.matched == 1; }));
    trio.write();
    ASSERT_TRUE(trio.world.run_until([&] { return second.changes.size() == 1; }, 300));
    move(trio, older, {"away"});
    ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 0; }, 300));
    keys = trio.stolen.all;
    trio.revoke_carol();
    ASSERT_TRUE(trio.revised(1)) << trio.text();
    trio.world.run(20);
  }
  void write(int count) {
    for (int i = 0; i < count; ++i) {
      trio.write();
      trio.world.run(20);
    }
  }

  Trio trio{in_partitions(GetParam())};
  Guid older;
  Result<Guid> made = Guid{};
  Qos second_qos;
  Listener second;
  KeyThief::Tokens keys;
};

TEST_P(TwoReadersOfBob, ReaderThatStayed_HearsTheNewKeys) {
  ASSERT_NO_FATAL_FAILURE(begin());
  write(5);
  EXPECT_EQ(second.changes.size(), 6U) << trio.text();
  until_former_keys_have_ended(trio);
  write(5);
  EXPECT_EQ(second.changes.size(), 11U) << trio.text();
}

TEST_P(TwoReadersOfBob, ReaderThatReturns_HearsTheNewKeys) {
  ASSERT_NO_FATAL_FAILURE(begin());
  until_former_keys_have_ended(trio);
  move(trio, older, {});
  ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 1; }, 300));
  trio.world.run(50);
  write(5);
  EXPECT_EQ(second.changes.size(), 6U) << trio.text();
  EXPECT_EQ(trio.b.listener.changes.size(), 6U) << trio.text();
}

// Alice does not notice that it was away, so she does not send its keys by herself.
TEST_P(TwoReadersOfBob, ReaderWhoseAbsenceWasNotNoticed_IsMatchedAgain) {
  ASSERT_TRUE(trio.match()) << trio.text();
  older = reader_of_bob(trio);
  write(1);
  trio.world.silence(trio.b);
  move(trio, older, {"away"});
  trio.world.run(20);
  ASSERT_EQ(trio.b.listener.matched, 0);
  move(trio, older, {});
  trio.world.run(20);
  trio.world.filter = {};
  ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 1; }, 300));
  EXPECT_EQ(trio.a.listener.unmatched, 0);
  write(5);
  EXPECT_EQ(trio.b.listener.changes.size(), 6U) << trio.text();
}

INSTANTIATE_TEST_SUITE_P(Governances, TwoReadersOfBob,
                         ::testing::Values(Rules{.metadata = kSign}, Rules{.metadata = kEncrypt},
                                           everything(kEncrypt), everything(kEncryptOa)));

using FormerKeys = TwoReadersOfBob;

TEST_P(FormerKeys, ReaderThatIsAway_LeavesNothingOpenForTheOther) {
  ASSERT_NO_FATAL_FAILURE(begin());
  const auto skip_to = [&](std::int64_t number, std::int32_t count) {
    forge(trio, keys, Heartbeat{kEntityIdUnknown, trio.writer.entity, {number}, {number}, count});
    return trio.b->local_endpoints().reader(*made)->writer(trio.writer)->next().value == number;
  };
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  ASSERT_TRUE(skip_to(kFar, 0xfffff)) << "what was forged had an effect";
  until_former_keys_have_ended(trio);
  EXPECT_FALSE(skip_to(kFar + 1, 0x1fffff));
  write(5);
  EXPECT_EQ(second.changes.size(), 6U) << trio.text();
}

// The only reader of bob returns, and carol keeps alice's new keys from it. Keys that came while it
// was away may be former ones, too.
TEST_P(FormerKeys, OnlyReaderThatReturned_OpensNothingWithThem) {
  for (const bool is_missed_late : {false, true}) {
    SCOPED_TRACE(is_missed_late ? "alice revises her keys before she knows" : "");
    Trio trio{in_partitions(GetParam())};
    ASSERT_TRUE(trio.match()) << trio.text();
    const auto reader = reader_of_bob(trio);
    trio.write();
    trio.world.run(20);
    if (is_missed_late) trio.world.silence(trio.b);
    move(trio, reader, {"away"});
    ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 0; }, 300));
    if (is_missed_late) {
      ASSERT_TRUE(trio.a->revise_keys());
      trio.world.run(700);  // she waits for bob only so long
      ASSERT_TRUE(trio.a.events.has(Code::rtps_keys_revised));
    }
    trio.world.filter = {};
    ASSERT_TRUE(trio.world.run_until([&] { return trio.a.listener.matched == 1; }, 300));
    const auto keys = trio.stolen.all;
    trio.revoke_carol();
    ASSERT_TRUE(trio.revised(1)) << trio.text();
    trio.world.run(700);
    until_former_keys_have_ended(trio);
    trio.world.silence(trio.a);
    move(trio, reader, {});
    trio.world.run(50);
    constexpr std::int64_t kFar = std::int64_t{1} << 40;
    forge(trio, keys, Heartbeat{kEntityIdUnknown, trio.writer.entity, {kFar}, {kFar}, 0xfffff});
    trio.world.filter = {};
    ASSERT_TRUE(trio.world.run_until([&] { return trio.b.listener.matched == 1; }, 300));
    for (int i = 0; i < 5; ++i) {
      trio.write();
      trio.world.run(20);
    }
    trio.world.run(100);
    EXPECT_EQ(trio.b.listener.changes.size(), 6U) << trio.text();
  }
}

INSTANTIATE_TEST_SUITE_P(Governances, FormerKeys,
                         ::testing::Values(Rules{.metadata = kSign}, Rules{.metadata = kEncrypt}));

}  // namespace
}  // namespace ddssec::rtps
