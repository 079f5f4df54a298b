// DURABILITY TRANSIENT and PERSISTENT between participants, across the end of writers and of whole
// participants.
#include <fstream>

#include "tests/unit/rtps_durability/durable_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct DurableWriterTest : DurableFixture {};

TEST_P(DurableWriterTest, ALateJoiner_GetsWhatWasWrittenBeforeARestart) {
  const auto qos = durable(DurabilityKind::persistent);
  {
    End end(services, with_store());
    auto& writer = end.writer(qos);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
    ASSERT_TRUE(writer.write({"south", 7}));
    ASSERT_TRUE(writer.dispose({"south"}));
    ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  }
  End end(services, with_store());
  auto& writer = end.writer(qos);
  EXPECT_FALSE(writer.lookup_instance({"north"}).is_nil());
  EXPECT_TRUE(writer.lookup_instance({"south"}).is_nil());
  auto& old = b.reader(late(DurabilityKind::persistent));
  auto& young = b.reader(reliable());
  EXPECT_EQ(all_of(end, old, 3), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_TRUE(taken(young).empty());
  ASSERT_TRUE(writer.write({"north", 3}));
  EXPECT_EQ(all_of(end, old, 1), (std::vector<std::int64_t>{3}));
  EXPECT_EQ(taken(young), (std::vector<std::int64_t>{3}));
}

TEST_P(DurableWriterTest, SourceTimesAndLifespans_OutliveARestart) {
  auto qos = durable(DurabilityKind::persistent);
  qos.lifespan = Duration::from(10s);
  std::optional<Time> written;
  {
    End end(services, with_store());
    auto& writer = end.writer(qos);
    ASSERT_TRUE(writer.write({"north", 1}));
    clock.advance(6s);
    written = Time::from(clock.calendar_nanoseconds());
    ASSERT_TRUE(writer.write({"north", 2}));
    ASSERT_TRUE(writer.wait_for_acknowledgments(10s));
  }
  clock.advance(6s);
  End end(services, with_store());
  end.writer(qos);
  auto& reader = b.reader(late(DurabilityKind::persistent));
  Samples<Reading> samples;
  for (int i = 0; i < 300 && samples.empty(); ++i) {
    end.participant->poll(0ms);
    run(1ms);
    ASSERT_TRUE(reader.take(samples));
  }
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].data.value, 2);
  EXPECT_EQ(samples[0].info.source_timestamp, written);
}

TEST_P(DurableWriterTest, TransientSamples_OutliveTheirWriterButNotTheParticipant) {
  const auto qos = durable(DurabilityKind::transient);
  {
    End end(services, options());
    ASSERT_TRUE(end.writer(qos).write({"north", 1}));
    ASSERT_TRUE(end.publisher->delete_contained_entities());
    end.writer(qos);
    EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::transient)), 1),
              (std::vector<std::int64_t>{1}));
  }
  End end(services, options());
  auto& writer = end.writer(qos);
  ASSERT_TRUE(writer.write({"north", 2}));
  EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::transient)), 1),
            (std::vector<std::int64_t>{2}));
}

TEST_P(DurableWriterTest, DurabilityService_SaysHowMuchIsKept) {
  const auto qos = durable(DurabilityKind::persistent, 2);
  {
    End end(services, with_store());
    auto& writer = end.writer(qos);
    for (int i = 0; i < 9; ++i) ASSERT_TRUE(writer.write({"north", i}));
  }  // the rest is stored at the end
  End end(services, with_store());
  end.writer(qos);
  EXPECT_EQ(all_of(end, b.reader(late(DurabilityKind::persistent)), 2),
            (std::vector<std::int64_t>{7, 8}));
}

// DDS 1.4, 2.2.3.5: HISTORY is for readers that exist, DURABILITY_SERVICE for those that come late.
TEST_P(DurableWriterTest, ALateJoiner_GetsMoreThanHistoryKeepsIfTheServiceKeepsMore) {
  auto qos = durable(DurabilityKind::transient, 1);
  for (const auto& [service, count] :
       {std::pair(keep_last(3), 3u), std::pair(keep_all(), 5u), std::pair(keep_last(1), 1u)}) {
    qos.durability_service = service;
    End end(services, options());
    auto& writer = end.writer(qos);
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(writer.write({"north", i}));
    auto& reader = end.reader(late(DurabilityKind::transient));
    std::vector<std::int64_t> got;
    for (int i = 0; i < 50 && got.size() < count; ++i) {
      end.participant->poll(0ms), run(10ms);
      for (auto value : taken(reader)) got.push_back(value);
    }
    EXPECT_EQ(got.size(), count);
    EXPECT_EQ(got.back(), 4);
  }
}

TEST_P(DurableWriterTest, AReaderThatStays_GetsNothingTwiceFromARestartedWriter) {
  const auto qos = durable(DurabilityKind::persistent);
  auto& stays = b.reader(late(DurabilityKind::persistent));
  for (int round = 0; round < 3; ++round) {
    End end(services, with_store());
    auto& writer = end.writer(qos);
    ASSERT_TRUE(writer.write({"north", round}));
    EXPECT_EQ(all_of(end, stays, 1), (std::vector<std::int64_t>{round}));
    auto& late_one = b.reader(late(DurabilityKind::persistent));
    EXPECT_EQ(all_of(end, late_one, static_cast<std::size_t>(round) + 1).size(), round + 1u);
    ASSERT_TRUE(b.subscriber->delete_datareader(late_one));
  }
}

TEST_P(DurableWriterTest, WriterWithoutAStore_KeepsPersistentSamplesInMemoryWithAWarning) {
  ASSERT_TRUE(a.writer(durable(DurabilityKind::persistent)).write({"north", 1}));
  const std::lock_guard held(events.mutex);
  ASSERT_EQ(std::ranges::count(events.all, Code::rtps_store_unusable,
                               [](const Event& event) { return event.error.code(); }),
            1);
}

TEST_P(DurableWriterTest, AStoreThatCannotBeUsed_IsAnErrorAtTheStart) {
  std::ofstream(folder / "samples") << std::string(5000, 'x');
  const auto participant = DomainParticipant::create(with_store(), services);
  ASSERT_FALSE(participant);
  EXPECT_EQ(participant.error().code(), Code::rtps_store_unusable);
  EXPECT_EQ(participant.error().details().document, folder / "samples");
}

INSTANTIATE_TEST_SUITE_P(Over, DurableWriterTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
