// Received samples: their keys, filters, writers and owners.
#include "rtps/dcps/received_samples.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/data_reader_listeners.hpp"
#include "rtps/dcps/read_conditions.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

using Reception = ReceivedSamples::Reception;

Guid guid_of(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

struct ReceivedSamplesTest : ::testing::Test {
  const TypeSupport type = type_support<Reading>();
  Qos qos = reliable();
  KeyProtection keys;
  MonotonicTime now = std::chrono::seconds(100);
  std::int64_t next = 1;

  Change change(const std::string& sensor, std::int64_t value = 0) {
    Bytes octets;
    serialize(Reading{.sensor = sensor, .value = value}, octets);
    Change out;
    out.writer = guid_of(1);
    out.sequence_number = {next++};
    out.payload = Payload::copy_of(octets);
    return out;
  }
  static Change unnamed_dispose(const Bytes& payload) {
    Change out;
    out.writer = guid_of(1);
    out.status.disposed = true;
    out.is_key_only = true;
    out.payload = Payload::copy_of(payload);
    return out;
  }
  Reception take(ReceivedSamples& samples, Change change, BoundFilter* filter = nullptr) {
    return samples.receive(change, filter, keys, {now, Time::from(now)}).outcome;
  }
  BoundFilter filter(const std::string& expression) const {
    return *BoundFilter::compile({expression, {}}, type.view());
  }
};

TEST_F(ReceivedSamplesTest, KeyedSample_WithoutHash_GetsItFromItsPayload) {
  ReceivedSamples samples(qos, type);
  auto one = change("kitchen");
  EXPECT_EQ(samples.receive(one, nullptr, keys, {now, Time::from(now)}).outcome, Reception::stored);
  ASSERT_TRUE(one.key_hash);
  EXPECT_FALSE(samples.cache().lookup(*one.key_hash).is_nil());
}

TEST_F(ReceivedSamplesTest, ProvenPayload_IsBelievedMoreThanTheHashBesideIt) {
  ReceivedSamples samples(qos, type);
  const KeyHash forged{9, 9, 9};
  for (const bool proven : {false, true}) {
    keys.proven = proven;
    auto one = change("kitchen");
    one.key_hash = forged;
    EXPECT_EQ(take(samples, one), Reception::stored);
    EXPECT_EQ(samples.cache().held().all().size(), proven ? 2u : 1u);
  }
}

// Otherwise an insider's copy of another writer's sample, with a short LIFESPAN, could end unread
// after the sample itself was dropped.
TEST_F(ReceivedSamplesTest, CopyWithAShorterLifespan_TakesNoPlaceOfTheSample) {
  using std::chrono::seconds;
  ReceivedSamples samples(qos, type);
  samples.expect_history();
  samples.cache().set_writer(guid_of(1), 0, kDurationInfinite);
  samples.cache().set_writer(guid_of(2), 0, Duration{{1, 0}});
  auto sample = change("kitchen", 5);
  sample.source_time = Time::from(now);
  auto copy = sample;
  copy.original = sample.origin();
  copy.writer = guid_of(2);
  EXPECT_EQ(take(samples, copy), Reception::stored);
  EXPECT_EQ(take(samples, sample), Reception::stored);
  now += seconds(2);
  samples.cache().expire(now);
  EXPECT_EQ(samples.cache().held().samples(), 1u);
}

// Otherwise each HEARTBEAT of its writer would make the reader deserialize a refused sample of 60
// MB twice.
TEST_F(ReceivedSamplesTest, RefusedChange_IsNotDeserializedAgain) {
  std::size_t hashes = 0, serialized = 0;
  auto counted = type;
  counted.key_hash = [&](const Change& of, bool hidden) {
    ++hashes;
    return type.key_hash(of, hidden);
  };
  counted.serialized_key = [&](const Change& of) {
    ++serialized;
    return type.serialized_key(of);
  };
  qos.resource_limits.max_instances = 1;
  keys.proven = true;
  ReceivedSamples samples(qos, counted);
  EXPECT_EQ(take(samples, change("kitchen")), Reception::stored);
  auto refused = change("cellar");
  const auto offer = [&] {
    return samples.receive(refused, nullptr, keys, {now, Time::from(now)}).outcome;
  };
  EXPECT_EQ(offer(), Reception::rejected);
  const auto before = std::pair(hashes, serialized);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(offer(), Reception::rejected);
  EXPECT_EQ(std::pair(hashes, serialized), before);
  auto end = change("kitchen");
  end.status = {true, true};
  EXPECT_EQ(take(samples, end), Reception::stored);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, {now, Time::from(now)}, out);
  EXPECT_EQ(offer(), Reception::stored);
  EXPECT_FALSE(refused.is_examined) << "another reader has to examine it";
}

// Copies that others keep of a writer's samples are compared by their digest, for which the payload
// is read.
TEST_F(ReceivedSamplesTest, RefusedChange_IsNotReadAgainForItsDigest) {
  qos.resource_limits.max_instances = 1;
  ReceivedSamples samples(qos, type);
  samples.expect_history();
  EXPECT_EQ(take(samples, change("kitchen")), Reception::stored);
  auto refused = change("cellar");
  refused.original = {guid_of(2), {1}};
  const Moment at{now, Time::from(now)};
  EXPECT_EQ(samples.receive(refused, nullptr, keys, at).outcome, Reception::rejected);
  const auto octets = std::exchange(refused.payload, Payload::uninitialized(std::size_t{1} << 30));
  for (int i = 0; i < 1000; ++i)
    ASSERT_EQ(samples.receive(refused, nullptr, keys, at).outcome, Reception::rejected);
  refused.payload = octets;
  auto end = change("kitchen");
  end.status = {true, true};
  EXPECT_EQ(take(samples, end), Reception::stored);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, at, out);
  EXPECT_EQ(samples.receive(refused, nullptr, keys, at).outcome, Reception::stored);
}

TEST_F(ReceivedSamplesTest, RefusedChange_HasPassedTheFilterOnce) {
  qos.resource_limits.max_instances = 1;
  ReceivedSamples samples(qos, type);
  auto above = filter("value > 10");
  EXPECT_EQ(take(samples, change("kitchen", 11), &above), Reception::stored);
  auto refused = change("cellar", 11);
  const Moment at{now, Time::from(now)};
  EXPECT_EQ(samples.receive(refused, &above, keys, at).outcome, Reception::rejected);
  auto below = filter("value < 10");
  EXPECT_EQ(samples.receive(refused, &below, keys, at).outcome, Reception::rejected);
}

TEST_F(ReceivedSamplesTest, UnreadableKey_IsCounted_AndReportedForAnEnd) {
  ReceivedSamples samples(qos, type);
  auto broken = change("kitchen");
  broken.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 9});
  EXPECT_EQ(take(samples, broken), Reception::unseen);
  EXPECT_EQ(take(samples, unnamed_dispose({0, 1, 0, 0, 9})), Reception::unreadable_key);
  EXPECT_EQ(samples.malformed(), 2u);
}

TEST_F(ReceivedSamplesTest, ContentFilter_KeepsOutSamplesAndTheEndsOfTheirInstances) {
  ReceivedSamples samples(qos, type);
  auto above = filter("value > 10");
  EXPECT_EQ(take(samples, change("low", 10), &above), Reception::unseen);
  EXPECT_EQ(take(samples, change("high", 11), &above), Reception::stored);
  auto end = change("low");
  end.status.disposed = true;
  EXPECT_EQ(take(samples, end, &above), Reception::unseen);
  end = change("high");
  end.status.disposed = true;
  EXPECT_EQ(take(samples, end, &above), Reception::stored);
  EXPECT_EQ(samples.cache().held().all().size(), 1u);
  EXPECT_EQ(samples.malformed(), 0u);
}

TEST_F(ReceivedSamplesTest, SampleOfTwoWriters_IsTakenOnceIfHistoryIsExpected) {
  for (const bool expects : {false, true}) {
    ReceivedSamples samples(qos, type);
    if (expects) samples.expect_history();
    auto first = change("kitchen", 1), again = first;
    again.writer = guid_of(2);
    again.original = {first.writer, first.sequence_number};
    EXPECT_EQ(take(samples, first), Reception::stored);
    EXPECT_EQ(take(samples, again), expects ? Reception::unseen : Reception::stored);
  }
}

// A durability service (3) sends what the strong writer (1) wrote, in that writer's name.
struct ExclusiveSamplesTest : ReceivedSamplesTest {
  ExclusiveSamplesTest() {
    qos.ownership = OwnershipKind::exclusive;
    samples.emplace(qos, type);
    samples->expect_history();
    samples->cache().set_writer(guid_of(1), 10, kDurationInfinite, {});
    samples->cache().set_writer(guid_of(2), 5, kDurationInfinite, {});
    samples->cache().set_writer(guid_of(3), std::numeric_limits<std::int32_t>::min(),
                                kDurationInfinite, {});
  }
  static Change kept(Change change) {
    change.original = {change.writer, change.sequence_number};
    change.writer = guid_of(3);
    return change;
  }
  Change of_weak(std::int64_t value) {
    auto out = change("kitchen", value);
    out.writer = guid_of(2);
    return out;
  }
  std::optional<ReceivedSamples> samples;
};

TEST_F(ExclusiveSamplesTest, OwnerOfAKeptSample_SendsItItself_OwnsItsInstance) {
  const auto strong = change("kitchen", 1);
  EXPECT_EQ(take(*samples, kept(strong)), Reception::stored);
  EXPECT_EQ(take(*samples, strong), Reception::unseen) << "it is there already";
  EXPECT_EQ(take(*samples, of_weak(2)), Reception::unseen) << "a stronger writer owns the instance";
  samples->cache().lose_writer(guid_of(1), ReaderCache::WriterLoss::unmatched, now);
  EXPECT_EQ(take(*samples, of_weak(3)), Reception::stored) << "the owner is gone";
}

TEST_F(ExclusiveSamplesTest, KeptSamplesThatAWeakerWriterReplaced_ComeAgainFromTheirWriter) {
  const auto first = change("kitchen", 1), second = change("kitchen", 2);
  EXPECT_EQ(take(*samples, kept(first)), Reception::stored);
  EXPECT_EQ(take(*samples, kept(second)), Reception::stored);
  EXPECT_EQ(take(*samples, of_weak(3)), Reception::stored) << "no stronger writer is known to live";
  EXPECT_EQ(take(*samples, first), Reception::stored);
  EXPECT_EQ(take(*samples, second), Reception::stored);
  EXPECT_EQ(take(*samples, second), Reception::unseen);
  EXPECT_EQ(take(*samples, of_weak(4)), Reception::unseen);
}

TEST_F(ReceivedSamplesTest, NoRoom_IsRejected_AndTakenWhenThereIsSome) {
  qos.resource_limits.max_samples = 1;
  ReceivedSamples samples(qos, type);
  samples.expect_history();
  EXPECT_EQ(take(samples, change("a")), Reception::stored);
  const auto second = change("a");
  EXPECT_EQ(take(samples, second), Reception::rejected);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, {now, Time::from(now)}, out);
  EXPECT_EQ(take(samples, second), Reception::stored);
}

TEST_F(ReceivedSamplesTest, Reset_OtherPolicies_Count) {
  ReceivedSamples samples(qos, type);
  qos.resource_limits.max_samples = 1;
  samples.reset(qos);
  EXPECT_EQ(take(samples, change("a")), Reception::stored);
  EXPECT_EQ(take(samples, change("a")), Reception::rejected);
}

}  // namespace
}  // namespace ddssec::rtps
