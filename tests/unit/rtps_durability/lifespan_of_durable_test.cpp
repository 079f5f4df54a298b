// LIFESPAN and service_cleanup_delay of durable writers and of the keeper, across restarts. Expired
// samples make room in the store, and late joiners do not get them.
#include "tests/unit/rtps_durability/keeper_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

Qos living(Duration lifespan = Duration{{10, 0}}) {
  auto qos = DurableFixture::durable(DurabilityKind::persistent);
  qos.history.kind = HistoryKind::keep_all;
  qos.durability_service.history.kind = HistoryKind::keep_all;
  qos.lifespan = lifespan;
  return qos;
}

struct DurableLifespanTest : DurableFixture {
  DomainParticipantOptions with_little_room() const {
    auto out = with_store();
    out.durability_store_octets = std::size_t{256} << 10;
    return out;
  }
  const std::string text = std::string(20, 'x');
  const std::vector<std::uint8_t> octets = std::vector<std::uint8_t>(2000);
};

// Otherwise the store of such a writer would be full after about 100 samples, and the writer would
// end.
TEST_P(DurableLifespanTest, AStoreOfLittleRoom_WithAShortLifespan_GoesOn) {
  for (int restart = 0; restart < 2; ++restart) {
    End end(services, with_little_room());
    auto& writer = end.writer(living());
    for (int i = 0; i < 300; ++i) {
      ASSERT_TRUE(writer.write({text, i, octets})) << i;
      ASSERT_TRUE(writer.wait_for_acknowledgments(10s)) << i;
      clock.advance(1s);
      end.participant->poll(0ms);
    }
    clock.advance(20s);
  }
}

TEST_P(DurableLifespanTest, ARestartedWriter_WithALongerLifespan_DoesNotServeWhatHasExpired) {
  {
    End end(services, with_store());
    auto& writer = end.writer(living());
    ASSERT_TRUE(writer.write({"north", 1}));
    clock.advance(4s);
    ASSERT_TRUE(writer.write({"north", 2}));
    ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  }
  End end(services, with_store());
  end.writer(living(Duration{{1000, 0}}));
  EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::persistent)), 2), (Values{1, 2}));
  clock.advance(6s);
  end.participant->poll(0ms);
  EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::persistent)), 1), (Values{2}));
}

// Without a timer, a writer that writes nothing would keep them.
TEST_P(DurableLifespanTest, DisposedInstances_LeaveTheStoreWhenTheirDelayIsOver) {
  auto qos = living(kDurationInfinite);
  qos.durability_service.cleanup_delay = Duration{{10, 0}};
  End end(services, with_store());
  auto& writer = end.writer(qos);
  ASSERT_TRUE(writer.write({"north", 1}));
  ASSERT_TRUE(writer.dispose({"north"}));
  ASSERT_TRUE(writer.write({"south", 2}));
  ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  clock.advance(11s);
  end.participant->poll(0ms);
  end.participant.reset();
  auto file = *Database::open(folder / "samples");
  EXPECT_EQ(file.number("SELECT count(*) FROM sample WHERE stream = (SELECT id FROM stream WHERE "
                        "topic = 'Readings')")
                .value_or(-1),
            1);
}

TEST_P(DurableLifespanTest, AChangedLifespan_CountsInTheStoreFromThenOn) {
  {
    End end(services, with_store());
    auto& writer = end.writer(living(kDurationInfinite));
    ASSERT_TRUE(writer.write({"north", 1}));
    ASSERT_TRUE(writer.set_qos(living()));
    ASSERT_TRUE(writer.write({"north", 2}));
    ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  }
  clock.advance(11s);
  End end(services, with_store());
  end.writer(living(kDurationInfinite));
  EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::persistent)), 1), (Values{1}));
}

INSTANTIATE_TEST_SUITE_P(Over, DurableLifespanTest,
                         ::testing::Values(Way::network, Way::in_process), name_of);

using KeeperLifespanTest = KeeperTest;

TEST_P(KeeperLifespanTest, ALateJoiner_GetsNothingExpired) {
  auto service = keeper();
  auto& writer = a.writer(living());
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  both(*service);
  clock.advance(6s);
  ASSERT_TRUE(writer.write({"north", 3}));
  both(*service);
  EXPECT_EQ(service->served(), 4u);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  both(*service);
  clock.advance(4s);
  both(*service);
  EXPECT_EQ(service->served(), 1u);
  EXPECT_EQ(late_joiner(*service, b, 1), (Values{3}));
  ASSERT_TRUE(service->flush(10s));
  service.reset();
  clock.advance(10s);
  service = keeper();
  both(*service);
  EXPECT_EQ(service->served(), 0u);
  EXPECT_EQ(late_joiner(*service, b, 0), Values{});
}

// The keeper serves several writers of a topic, and the first one does not decide for the others.
TEST_P(KeeperLifespanTest, EachWriter_HasItsOwnLifespan) {
  auto service = keeper();
  auto& first = a.writer(living(Duration{{2, 0}}));
  ASSERT_TRUE(keeps(*service, 1));
  auto& other = b.writer(living(kDurationInfinite));
  both(*service);
  ASSERT_TRUE(first.write({"north", 1}));
  ASSERT_TRUE(other.write({"north", 2}));
  both(*service);
  EXPECT_EQ(service->served(), 2u);
  clock.advance(3s);
  both(*service);
  EXPECT_EQ(service->served(), 1u);
  EXPECT_EQ(service->topics(), 1u);
}

// A late joiner must not apply the LIFESPAN of the topic's first writer to all samples, or it would
// get nothing of a writer whose samples are kept for longer.
TEST_P(KeeperLifespanTest, FirstWriterWithAShortLifespan_LateJoiner_GetsTheSamplesOfOthers) {
  auto service = keeper();
  auto& first = a.writer(living(Duration{{2, 0}}));
  ASSERT_TRUE(keeps(*service, 1));
  auto& other = a.writer(living(Duration{{100, 0}}));
  both(*service);
  ASSERT_TRUE(first.write({"north", 1}));
  ASSERT_TRUE(other.write({"north", 2}));
  both(*service);
  ASSERT_TRUE(service->flush(10s));
  both(*service);
  ASSERT_TRUE(a.publisher->delete_contained_entities());
  clock.advance(3s);
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 1), Values{2});
  service.reset();
  clock.advance(3s);
  service = keeper();
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 1), Values{2}) << "after a restart";
}

TEST_P(KeeperLifespanTest, WhatHasExpired_LeavesRoomForTheNextSample) {
  auto service = keeper();
  auto qos = living();
  qos.durability_service.limits.max_samples = 1;
  auto& writer = a.writer(qos);
  ASSERT_TRUE(keeps(*service, 1));
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(writer.write({"north", i}));
    both(*service);
    EXPECT_EQ(service->served(), 1u);
    clock.advance(11s);
  }
  ASSERT_TRUE(writer.write({"north", 3}));
  run();  // it arrives before a timer has run
  both(*service);
  EXPECT_EQ(late_joiner(*service, b, 1), Values{3});
}

INSTANTIATE_TEST_SUITE_P(Over, KeeperLifespanTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
