// Coherent and ordered access, end to end, and what is held back.
#include <algorithm>
#include <thread>

#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/presenting.hpp"

namespace ddssec::rtps::presenting {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::reliable;
using testing::taken;

TEST_P(Presenting, ACoherentSet_ComesAsAWhole) {
  for (const auto scope : {PresentationScope::instance, PresentationScope::topic}) {
    auto& pub = publisher({scope, true, false});
    auto& writer = writer_on(*a.topic, pub);
    auto& coherent = reader_on(*b.topic, subscriber({scope, true, false}));
    auto& plain = b.reader(reliable());
    ASSERT_TRUE(match(writer, coherent));
    ASSERT_TRUE(match(writer, plain));
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));  // this call is nested
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i})));
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
    run(20ms);
    EXPECT_THAT(taken(plain), ElementsAre(0, 1, 2));
    EXPECT_THAT(taken(coherent), IsEmpty());
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
    run(20ms);
    EXPECT_THAT(taken(coherent), ElementsAre(0, 1, 2));
    ASSERT_TRUE(succeeds(writer.write({"a", 3})));  // this sample is in no set
    run(20ms);
    EXPECT_THAT(taken(coherent), ElementsAre(3));
    EXPECT_THAT(taken(plain), ElementsAre(3));
    (void)writer.wait_for_acknowledgments(0ms);  // asks for acknowledgments
    run(20ms);
    EXPECT_TRUE(succeeds(writer.wait_for_acknowledgments(0ms)));
    ASSERT_TRUE(succeeds(a.publisher->delete_contained_entities()));
    ASSERT_TRUE(succeeds(pub.delete_contained_entities()));
    ASSERT_TRUE(succeeds(b.subscriber->delete_contained_entities()));
    run(50ms);
  }
}

// A set waits for all limits of the reader, because its writer has been told that it arrived.
TEST_P(Presenting, ASet_WaitsForRoomInItsInstances) {
  const Presentation access{PresentationScope::topic, true, false};
  auto& pub = publisher(access);
  auto& sub = subscriber(access);
  auto qos = reliable();
  qos.history = {.kind = HistoryKind::keep_all};
  auto& writer = **pub.create_datawriter<Reading>(*a.topic, qos);
  qos.resource_limits = {.max_samples = 100, .max_instances = 2, .max_samples_per_instance = 2};
  auto& reader = **sub.create_datareader<Reading>(*b.topic, qos);
  ASSERT_TRUE(match(writer, reader));
  const auto write_set = [&](std::initializer_list<Reading> samples) {
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
    for (const auto& sample : samples) ASSERT_TRUE(succeeds(writer.write(sample)));
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
    run(20ms);
  };
  write_set({{"a", 1}, {"b", 2}});
  write_set({{"a", 3}, {"b", 4}});
  write_set({{"b", 5}, {"a", 6}});
  EXPECT_THAT(taken(reader), ElementsAre(1, 3, 2, 4));
  run(20ms);
  EXPECT_THAT(taken(reader), ElementsAre(5, 6));
  write_set({{"a", 7}, {"a", 8}, {"a", 9}});  // this set never fits
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_EQ(reader.sample_lost_status().total_count, 3);
  EXPECT_EQ(reader.sample_rejected_status().total_count, 0);
}

// Otherwise the set would be seen sample by sample, for as long as the reader takes them: a minute
// for 20,000 samples.
TEST_P(Presenting, ASetThatAKeepLastReaderCanNeverHold_IsGivenUpAtOnce) {
  for (const auto scope : {PresentationScope::topic, PresentationScope::group}) {
    const Presentation access{scope, true, true};
    auto& pub = publisher(access);
    auto& sub = subscriber(access);
    auto qos = reliable();
    qos.history = {.kind = HistoryKind::keep_all};
    auto& writer = **pub.create_datawriter<Reading>(*a.topic, qos);
    qos.history = {.kind = HistoryKind::keep_last, .depth = 1};
    qos.resource_limits.max_samples = 3;
    auto& reader = **sub.create_datareader<Reading>(*b.topic, qos);
    ASSERT_TRUE(match(writer, reader));
    const auto write_set = [&](int samples) {
      ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
      for (int i = 0; i < samples; ++i) ASSERT_TRUE(succeeds(writer.write({std::to_string(i), i})));
      ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
      run(20ms);
    };
    const auto seen = [&] {
      EXPECT_TRUE(succeeds(sub.begin_access()));
      auto out = taken(reader);
      EXPECT_TRUE(succeeds(sub.end_access()));
      return out;
    };
    write_set(3);
    EXPECT_THAT(seen(), ElementsAre(0, 1, 2));
    write_set(4);
    EXPECT_THAT(seen(), IsEmpty());
    EXPECT_EQ(reader.sample_lost_status().total_count, 4);
    EXPECT_EQ(reader.sample_rejected_status().total_count, 0);
    write_set(2);
    EXPECT_THAT(seen(), ElementsAre(0, 1));
    ASSERT_TRUE(succeeds(pub.delete_contained_entities()));
    ASSERT_TRUE(succeeds(sub.delete_contained_entities()));
    run(50ms);
  }
}

// The writer has been told that the sets arrived.
TEST_P(Presenting, SetsThatWaitForRoom_ComeAfterTheirWriterHasLeft) {
  const Presentation access{PresentationScope::topic, true, false};
  auto& pub = publisher(access);
  auto qos = reliable();
  qos.history = {.kind = HistoryKind::keep_all};
  auto& writer = **pub.create_datawriter<Reading>(*a.topic, qos);
  qos.resource_limits = {.max_samples = 2, .max_instances = 2, .max_samples_per_instance = 2};
  auto& reader = **subscriber(access).create_datareader<Reading>(*b.topic, qos);
  ASSERT_TRUE(match(writer, reader));
  for (int i = 0; i < 6; i += 2) {
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
    ASSERT_TRUE(succeeds(writer.write({"a", i})));
    ASSERT_TRUE(succeeds(writer.write({"a", i + 1})));
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  }
  run(20ms);
  ASSERT_TRUE(succeeds(pub.delete_datawriter(writer)));
  run(50ms);
  EXPECT_EQ(reader.subscription_matched_status().current_count, 0);
  EXPECT_THAT(taken(reader), ElementsAre(0, 1));
  EXPECT_THAT(taken(reader), ElementsAre(2, 3));
  EXPECT_THAT(taken(reader), ElementsAre(4, 5));
  EXPECT_EQ(reader.sample_lost_status().total_count, 0);
  const auto end = reader.take_next_sample();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->info.instance_state, InstanceState::not_alive_disposed);
}

TEST_P(Presenting, ASet_WaitsWhileAnotherWriterHasAllInstances) {
  const Presentation access{PresentationScope::topic, true, false};
  auto& pub = publisher(access);
  auto qos = reliable();
  qos.history = {.kind = HistoryKind::keep_all};
  auto& writer = **pub.create_datawriter<Reading>(*a.topic, qos);
  auto& other = **pub.create_datawriter<Reading>(*a.topic, qos);
  qos.resource_limits = {.max_samples = 100, .max_instances = 2, .max_samples_per_instance = 2};
  auto& reader = **subscriber(access).create_datareader<Reading>(*b.topic, qos);
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(match(other, reader));
  for (const auto* key : {"x", "y"}) ASSERT_TRUE(succeeds(other.write({key, 1})));
  run(20ms);
  EXPECT_THAT(taken(reader), ElementsAre(1, 1));
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  for (const auto* key : {"a", "b"}) ASSERT_TRUE(succeeds(writer.write({key, 2})));
  ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  run(20ms);
  EXPECT_THAT(taken(reader), IsEmpty());
  ASSERT_TRUE(succeeds(pub.delete_datawriter(other)));
  run(50ms);
  (void)taken(reader);  // takes the ends of the two instances
  run(20ms);
  EXPECT_THAT(taken(reader), ElementsAre(2, 2));
  EXPECT_EQ(reader.sample_lost_status().total_count, 0);
}

TEST_P(Presenting, AReaderThatComesInTheMiddleOfASet_GetsTheNext) {
  const Presentation access{PresentationScope::topic, true, false};
  auto& pub = publisher(access);
  auto& writer = writer_on(*a.topic, pub);
  auto& early = reader_on(*b.topic, subscriber(access));
  ASSERT_TRUE(match(writer, early));
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(20ms);
  auto& late = reader_on(*b.topic, subscriber(access));
  ASSERT_TRUE(match(writer, late));
  ASSERT_TRUE(succeeds(writer.write({"a", 2})));
  ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  run(20ms);
  EXPECT_THAT(taken(early), ElementsAre(1, 2));
  EXPECT_THAT(taken(late), IsEmpty());
  EXPECT_EQ(late.sample_lost_status().total_count, 1);
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  ASSERT_TRUE(succeeds(writer.write({"a", 3})));
  ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
  run(20ms);
  EXPECT_THAT(taken(late), ElementsAre(3));
}

TEST_P(Presenting, AWriterThatEndsInTheMiddleOfASet_LeavesNothing) {
  const Presentation access{PresentationScope::topic, true, false};
  auto& pub = publisher(access);
  auto qos = reliable();
  qos.autodispose_unregistered_instances = false;
  auto& writer = **pub.create_datawriter<Reading>(*a.topic, qos);
  auto& reader = reader_on(*b.topic, subscriber(access));
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
  ASSERT_TRUE(succeeds(writer.write({"a", 1})));
  run(20ms);
  ASSERT_TRUE(succeeds(pub.delete_datawriter(writer)));
  run(50ms);
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_EQ(reader.sample_lost_status().total_count, 1);
}

TEST_P(Presenting, OrderedByTopic_SamplesOfAllInstancesComeInOrder) {
  const Presentation access{PresentationScope::topic, false, true};
  auto& writer = writer_on(*a.topic, publisher(access));
  auto& ordered = reader_on(*b.topic, subscriber(access));
  auto& plain = b.reader(reliable());
  ASSERT_TRUE(match(writer, ordered));
  ASSERT_TRUE(match(writer, plain));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(succeeds(writer.write({i % 2 == 0 ? "a" : "b", i})));
  run(20ms);
  Samples<Reading> samples;
  ASSERT_EQ(ordered.read(samples, 4), 4u);
  EXPECT_THAT(testing::values(samples), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(samples[0].info.sample_rank, 1);
  EXPECT_EQ(samples[3].info.sample_rank, 0);
  EXPECT_THAT(taken(ordered), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(taken(plain), ElementsAre(0, 2, 4, 1, 3, 5));
}

// One thread writes two topics in one set, and another thread reads them. No access sees one
// topic's part without the other's.
TEST(PresentingConcurrently, OneAccess_SeesAllTopicsOfASetOrNone) {
  constexpr std::int64_t kSets = 300;
  const SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;
  const PluginServices services{clock, random, events};
  for (const auto scope : {PresentationScope::instance, PresentationScope::topic}) {
    for (const bool is_in_process : {true, false}) {
      const DomainParticipantOptions options{
          .domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
          .domain_tag = "sets" + std::to_string(::getpid()),
          .interfaces = {"127.0.0.1"},
          .multicast = false,
          .delivers_in_process = is_in_process};
      testing::End a(services, options), b(services, options);
      const Presentation access{scope, true, false};
      auto& pub = a.participant->create_publisher({.presentation = access});
      auto& sub = b.participant->create_subscriber({.presentation = access});
      std::vector<DataWriter<Reading>*> writers;
      std::vector<DataReader<Reading>*> readers;
      for (const auto* name : {"One", "Two", "Three"}) {
        writers.push_back(*pub.create_datawriter<Reading>(
            **a.participant->create_topic<Reading>(name), reliable()));
        readers.push_back(*sub.create_datareader<Reading>(
            **b.participant->create_topic<Reading>(name), reliable()));
      }
      const auto matched = [&] {
        return std::ranges::all_of(
                   writers, [](auto* w) { return w->matched_subscriptions().size() == 1; }) &&
               std::ranges::all_of(readers,
                                   [](auto* r) { return r->matched_publications().size() == 1; });
      };
      for (int i = 0; i < 2000 && !matched(); ++i) std::this_thread::sleep_for(5ms);
      ASSERT_TRUE(matched());
      std::jthread writing([&] {
        for (std::int64_t i = 1; i <= kSets; ++i) {
          EXPECT_TRUE(succeeds(pub.begin_coherent_changes()));
          for (auto* writer : writers) EXPECT_TRUE(succeeds(writer->write({"a", i})));
          EXPECT_TRUE(succeeds(pub.end_coherent_changes()));
          if (i % 8 == 0) std::this_thread::yield();
        }
      });
      std::array<std::int64_t, 3> last{};
      const auto end = std::chrono::steady_clock::now() + 60s;
      while (last[2] < kSets && std::chrono::steady_clock::now() < end) {
        ASSERT_TRUE(succeeds(sub.begin_access()));
        for (std::size_t i = 0; i < readers.size(); ++i)
          if (const auto values = taken(*readers[i]); !values.empty()) last[i] = values.back();
        ASSERT_TRUE(succeeds(sub.end_access()));
        ASSERT_EQ(last[0], last[1]) << is_in_process;
        ASSERT_EQ(last[0], last[2]) << is_in_process;
      }
      EXPECT_EQ(last[0], kSets);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Over, Presenting,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps::presenting
