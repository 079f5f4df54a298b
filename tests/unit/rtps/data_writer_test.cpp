// The calls of a writer: instances, octets, and samples that are too large.
#include "rtps/dcps/data_writer.hpp"

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using testing::code_of;
using ::testing::IsEmpty;
using testing::reliable;
using testing::taken;

TEST_P(Access, InstancesOfTheWriter_AreRegisteredAndEnded) {
  const auto handle = *writer.register_instance({"a"});
  EXPECT_EQ(writer.lookup_instance({"a"}), handle);
  EXPECT_EQ(writer.key_value(handle)->sensor, "a");
  EXPECT_TRUE(succeeds(writer.write({"a", 1}, handle)));
  EXPECT_EQ(code_of(writer.write({"b", 1}, handle)), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(writer.unregister_instance({"b"})), Code::rtps_precondition_not_met);
  EXPECT_TRUE(succeeds(writer.unregister_instance({"a"}, handle)));
  EXPECT_TRUE(writer.lookup_instance({"a"}).is_nil());
  EXPECT_EQ(code_of(writer.key_value(handle)), Code::rtps_bad_parameter);
  run();
  EXPECT_EQ(reader.take(samples), 2u);
  // By default a writer disposes what it unregisters.
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
}

TEST_P(Access, Unregistering_NeedNotDispose) {
  auto qos = writer.qos();
  qos.autodispose_unregistered_instances = false;
  ASSERT_TRUE(succeeds(writer.set_qos(qos)));
  write("a", 1);
  ASSERT_TRUE(succeeds(writer.unregister_instance_w_timestamp({"a"}, {}, Time{{5, 0}})));
  run();
  EXPECT_EQ(reader.take(samples), 2u);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_no_writers);
  EXPECT_EQ(samples[1].info.source_timestamp, (Time{{5, 0}}));
  ASSERT_TRUE(succeeds(writer.dispose_w_timestamp({"a"}, {}, Time{{6, 0}})));
  run();
  EXPECT_EQ(reader.take(samples), 1u);
  EXPECT_EQ(samples[0].info.source_timestamp, (Time{{6, 0}}));
}

TEST_P(Access, Octets_GoInAndComeOut) {
  auto* octets = *b.subscriber->create_datareader(*b.topic, reliable());
  ASSERT_TRUE(match(writer, *octets));
  write("a", 5);
  std::vector<OctetSample> raw;
  EXPECT_EQ(octets->read(raw), 1u);
  EXPECT_EQ(deserialize<Reading>(raw[0].payload.view())->value, 5);
  ASSERT_TRUE(succeeds(writer.dispose({"a"})));
  run();
  EXPECT_EQ(octets->take(raw), 2u);
  EXPECT_TRUE(raw[1].is_key_only);
  EXPECT_EQ(deserialize_key<Reading>(raw[1].payload.view())->sensor, "a");
  auto* sender = *a.publisher->create_datawriter(*a.topic, reliable());
  ASSERT_TRUE(match(*sender, reader));
  Bytes payload, scratch;
  const Reading sample{"raw", 9};
  serialize(sample, payload);
  EXPECT_EQ(code_of(sender->write_octets({.payload = payload})), Code::rtps_bad_parameter);
  ASSERT_TRUE(
      succeeds(sender->write_octets({.payload = payload, .key = key_hash(sample, scratch)})));
  run();
  taken(reader);
  ASSERT_TRUE(succeeds(sender->write_octets({.payload = Bytes{0, 1, 0, 0, 9}, .key = KeyHash{1}})));
  run();
  EXPECT_THAT(taken(reader), IsEmpty());
  EXPECT_EQ(reader.malformed(), 1u);
}

// The payload in the history is the only memory that the sample takes.
TEST_P(Access, LargeSample_TakesMemoryOnce) {
  constexpr std::size_t kSize = Payload::kMaxKeptOctets + (4u << 20);  // freed at once
  auto qos = reliable(HistoryKind::keep_last);
  qos.durability = DurabilityKind::transient_local;
  auto* topic = *a.participant->create_topic<Reading>("Unread");
  auto& alone = **a.publisher->create_datawriter<Reading>(*topic, qos);
  const Reading large{"a", 1, Bytes(kSize)};
  const auto held = [] { return static_cast<std::size_t>(counted_memory::octets()); };
  const auto before = held();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(succeeds(alone.write(large)));
  EXPECT_LT(held() - before, kSize + kSize / 2);
}

// Readers drop larger samples after they have acknowledged them.
TEST_P(Access, ASampleBeyondTheLargest_IsRefusedAtWrite) {
  Reading large{"a", 1, Bytes(StatefulReader::kMaxSample)};
  const auto refused = writer.write(large);
  ASSERT_EQ(code_of(refused), Code::rtps_sample_too_large);
  EXPECT_EQ(refused.error().details().expected, "at most 67108864");
  EXPECT_TRUE(writer.lookup_instance(large).is_nil());
  EXPECT_TRUE(succeeds(writer.write({"a", 1})));
}

}  // namespace
}  // namespace ddssec::rtps::accesses
