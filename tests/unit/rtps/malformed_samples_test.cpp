// An authorized writer sends samples that are not of the reader's type. No call of the reader
// reports "no data" while it holds samples of other writers.
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A TRANSIENT writer sends key hashes, which name the instances of samples that cannot be
// deserialized.
Qos transient() {
  auto qos = reliable();
  qos.durability = DurabilityKind::transient;
  return qos;
}

struct MalformedSamples : Polled {
  AnyDataWriter& hostile = **a.publisher->create_datawriter(*a.topic, transient());
  DataWriter<Reading>& honest = a.writer(reliable());
  DataReader<Reading>& reader = b.reader(reliable());
  Samples<Reading> samples;

  void SetUp() override {
    ASSERT_TRUE(match(hostile, reader));
    ASSERT_TRUE(match(honest, reader));
  }
  // Writes a string that claims 0x7fffffff octets, in an instance of its own.
  void write_malformed(std::uint8_t instance) {
    const Bytes payload{0, 1, 0, 0, 0xff, 0xff, 0xff, 0x7f, 1, 2, 3, 4};
    ASSERT_TRUE(hostile.write_octets({.payload = payload, .key = KeyHash{instance}}));
    run();
  }
  // Writes a malformed sample in the instance of an honest writer.
  void write_malformed(const std::string& sensor) {
    Bytes scratch;
    const auto key = key_hash(Reading{sensor}, scratch);
    ASSERT_TRUE(hostile.write_octets({.payload = Bytes{0, 1, 0, 0, 9}, .key = key}));
    run();
  }
  void write(const std::string& sensor, std::int64_t value) {
    ASSERT_TRUE(honest.write({sensor, value}));
    run();
  }
  std::size_t reported() {
    const std::lock_guard lock(events.mutex);
    return static_cast<std::size_t>(
        std::ranges::count(events.all, Code::rtps_sample_malformed,
                           [](const Event& event) { return event.error.code(); }));
  }
  // Walks all instances by their handles, and returns the values.
  template <class Next>
  std::vector<std::int64_t> walk(Next&& next) {
    std::vector<std::int64_t> out;
    InstanceHandle previous;
    while (next(previous).value_or(0) > 0) {
      for (const auto value : values(samples)) out.push_back(value);
      previous = samples[0].info.instance_handle;
    }
    return out;
  }
};

TEST_P(MalformedSamples, BeforeHonestInstances_ReadNextInstanceGoesOn) {
  write_malformed(1), write("a", 10), write_malformed(2), write_malformed(3), write("b", 20);
  const auto next = [&](InstanceHandle previous) {
    return reader.read_next_instance(samples, previous);
  };
  EXPECT_THAT(walk(next), ElementsAre(10, 20));
  EXPECT_EQ(reader.malformed(), 3u);
  EXPECT_THAT(walk(next), ElementsAre(10, 20));
  EXPECT_EQ(reader.malformed(), 3u);  // they are removed
  EXPECT_EQ(reported(), 2u);          // for the first and the second one
}

TEST_P(MalformedSamples, BeforeHonestInstances_TakeNextInstanceGoesOn) {
  write_malformed(1), write_malformed(2), write("a", 10), write_malformed(3), write("b", 20);
  EXPECT_THAT(
      walk([&](InstanceHandle previous) { return reader.take_next_instance(samples, previous); }),
      ElementsAre(10, 20));
  EXPECT_EQ(reader.malformed(), 3u);
  EXPECT_EQ(reader.take(samples), 0u);
}

TEST_P(MalformedSamples, BeforeHonestInstances_ConditionsGoOn) {
  write_malformed(1), write("a", 10), write_malformed(2), write("b", 20);
  auto& condition = reader.create_readcondition({.sample = SampleState::not_read});
  EXPECT_THAT(walk([&](InstanceHandle previous) {
                return reader.read_next_instance_w_condition(samples, previous, condition);
              }),
              ElementsAre(10, 20));
  EXPECT_FALSE(condition.trigger_value());
  write_malformed(3), write("c", 30), write_malformed(4), write("d", 40);
  EXPECT_EQ(reader.take_w_condition(samples, condition, 1), 1u);
  EXPECT_EQ(reader.take_w_condition(samples, condition, 1), 1u);
  EXPECT_FALSE(condition.trigger_value());
}

TEST_P(MalformedSamples, SamplesInALimitedTake_AreReplacedByTheNextOnes) {
  for (const std::uint8_t instance : {1, 2, 3}) write_malformed(instance);
  write("a", 10), write("a", 11), write_malformed(4), write("b", 20);
  EXPECT_EQ(reader.take(samples, 2), 2u);
  EXPECT_THAT(values(samples), ElementsAre(10, 11));
  EXPECT_EQ(reader.take(samples, 1), 1u);
  EXPECT_THAT(values(samples), ElementsAre(20));
  EXPECT_EQ(reader.take(samples, 1), 0u);
}

TEST_P(MalformedSamples, SamplesInALimitedRead_AreReplacedByTheNextUnreadOnes) {
  for (const std::uint8_t instance : {1, 2}) write_malformed(instance);
  write("a", 10), write_malformed(3), write("b", 20);
  const States unread{.sample = SampleState::not_read};
  EXPECT_EQ(reader.read(samples, 1, unread), 1u);
  EXPECT_THAT(values(samples), ElementsAre(10));
  EXPECT_EQ(reader.read(samples, 2, unread), 1u);
  EXPECT_THAT(values(samples), ElementsAre(20));
  EXPECT_EQ(reader.read(samples, 1), 1u);  // in all states, no sample is twice in one collection
  EXPECT_EQ(reader.read(samples), 2u);
}

TEST_P(MalformedSamples, SamplesInAnHonestInstance_LeaveTheOthersAndTheirRanks) {
  write("a", 10), write_malformed("a"), write("a", 11), write_malformed("a");
  const auto instance = reader.lookup_instance({"a"});
  EXPECT_EQ(reader.read_instance(samples, instance), 2u);
  EXPECT_THAT(values(samples), ElementsAre(10, 11));
  EXPECT_EQ(samples[0].info.sample_rank, 1);
  EXPECT_EQ(samples[1].info.sample_rank, 0);
  write_malformed("a"), write("a", 12);
  EXPECT_EQ(reader.take_instance(samples, instance, 2), 2u);
  EXPECT_EQ(reader.take_instance(samples, instance, 1), 1u);
  EXPECT_THAT(values(samples), ElementsAre(12));
}

TEST_P(MalformedSamples, SamplesInAnHonestInstance_AreReplacedWithinIt) {
  write_malformed("a"), write("a", 10), write("a", 11), write("b", 20);
  EXPECT_EQ(reader.take_next_instance(samples, {}, 2), 2u);
  EXPECT_THAT(values(samples), ElementsAre(10, 11));
  EXPECT_EQ(samples[1].info.view_state, ViewState::new_);  // as for the first sample
}

TEST_P(MalformedSamples, OneByOne_AreSkipped) {
  write_malformed(1), write_malformed(2), write("a", 10), write_malformed(3);
  EXPECT_EQ(reader.read_next_sample()->data.value, 10);
  EXPECT_FALSE(reader.read_next_sample());
  write_malformed(4), write("a", 11);
  EXPECT_EQ(reader.take_next_sample()->data.value, 11);
  EXPECT_FALSE(reader.take_next_sample());
  EXPECT_EQ(reader.malformed(), 4u);
}

// Malformed samples give their places to samples that were refused for lack of room.
TEST_P(MalformedSamples, SamplesInAFullReader_GiveUpTheirPlaces) {
  auto qos = reliable();
  qos.resource_limits.max_samples = 2;
  auto& full = b.reader(qos);
  ASSERT_TRUE(match(hostile, full));
  ASSERT_TRUE(match(honest, full));
  write_malformed(1), write_malformed(2), write("a", 10);
  EXPECT_TRUE(eventually([&] { return full.read(samples).value_or(0) == 1; }));
  EXPECT_THAT(values(samples), ElementsAre(10));
}

INSTANTIATE_TEST_SUITE_P(Ways, MalformedSamples, ::testing::Values(Way::network, Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
