// The parts of a DataReader, each by itself: what it takes, its conditions, presentation,
// liveliness and listeners.
#include <gmock/gmock.h>

#include "rtps/dcps/data_reader_listeners.hpp"
#include "rtps/dcps/entity.hpp"
#include "rtps/dcps/read_conditions.hpp"
#include "rtps/dcps/reader_presentation.hpp"
#include "rtps/dcps/received_samples.hpp"
#include "rtps/dcps/requested_liveliness.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Outcome = ReceivedSamples::Outcome;

Guid guid_of(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

// -- ReceivedSamples

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
    out.key_only = true;
    out.payload = Payload::copy_of(payload);
    return out;
  }
  Outcome take(ReceivedSamples& samples, Change change, BoundFilter* filter = nullptr) {
    return samples.take(change, filter, keys, {now, Time::from(now)}).outcome;
  }
  BoundFilter filter(const std::string& expression) const {
    return *BoundFilter::compile({expression, {}}, type.view());
  }
};

TEST_F(ReceivedSamplesTest, KeyedSample_WithoutHash_GetsItFromItsPayload) {
  ReceivedSamples samples(qos, type);
  auto one = change("kitchen");
  EXPECT_EQ(samples.take(one, nullptr, keys, {now, Time::from(now)}).outcome, Outcome::stored);
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
    EXPECT_EQ(take(samples, one), Outcome::stored);
    EXPECT_EQ(samples.cache().instances(), proven ? 2u : 1u);
  }
}

// Each HEARTBEAT of its writer made the reader deserialize a refused sample of 60 MB twice.
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
  EXPECT_EQ(take(samples, change("kitchen")), Outcome::stored);
  auto refused = change("cellar");
  const auto offer = [&] {
    return samples.take(refused, nullptr, keys, {now, Time::from(now)}).outcome;
  };
  EXPECT_EQ(offer(), Outcome::rejected);
  const auto before = std::pair(hashes, serialized);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(offer(), Outcome::rejected);
  EXPECT_EQ(std::pair(hashes, serialized), before);
  auto end = change("kitchen");
  end.status = {true, true};
  EXPECT_EQ(take(samples, end), Outcome::stored);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, {now, Time::from(now)}, out);
  EXPECT_EQ(offer(), Outcome::stored);
  EXPECT_FALSE(refused.is_examined) << "another reader has to examine it";
}

// What others keep of a writer is compared by its digest, for which the payload is read.
TEST_F(ReceivedSamplesTest, RefusedChange_IsNotReadAgainForItsDigest) {
  qos.resource_limits.max_instances = 1;
  ReceivedSamples samples(qos, type);
  samples.expect_history();
  EXPECT_EQ(take(samples, change("kitchen")), Outcome::stored);
  auto refused = change("cellar");
  refused.original = {guid_of(2), {1}};
  const Moment at{now, Time::from(now)};
  EXPECT_EQ(samples.take(refused, nullptr, keys, at).outcome, Outcome::rejected);
  const auto octets = std::exchange(refused.payload, Payload::uninitialized(std::size_t{1} << 30));
  for (int i = 0; i < 1000; ++i)
    ASSERT_EQ(samples.take(refused, nullptr, keys, at).outcome, Outcome::rejected);
  refused.payload = octets;
  auto end = change("kitchen");
  end.status = {true, true};
  EXPECT_EQ(take(samples, end), Outcome::stored);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, at, out);
  EXPECT_EQ(samples.take(refused, nullptr, keys, at).outcome, Outcome::stored);
}

TEST_F(ReceivedSamplesTest, RefusedChange_HasPassedTheFilterOnce) {
  qos.resource_limits.max_instances = 1;
  ReceivedSamples samples(qos, type);
  auto above = filter("value > 10");
  EXPECT_EQ(take(samples, change("kitchen", 11), &above), Outcome::stored);
  auto refused = change("cellar", 11);
  const Moment at{now, Time::from(now)};
  EXPECT_EQ(samples.take(refused, &above, keys, at).outcome, Outcome::rejected);
  auto below = filter("value < 10");
  EXPECT_EQ(samples.take(refused, &below, keys, at).outcome, Outcome::rejected);
}

TEST_F(ReceivedSamplesTest, UnreadableKey_IsCounted_AndReportedForAnEnd) {
  ReceivedSamples samples(qos, type);
  auto broken = change("kitchen");
  broken.payload = Payload::copy_of(Bytes{0, 1, 0, 0, 9});
  EXPECT_EQ(take(samples, broken), Outcome::unseen);
  EXPECT_EQ(take(samples, unnamed_dispose({0, 1, 0, 0, 9})), Outcome::unreadable_key);
  EXPECT_EQ(samples.malformed(), 2u);
}

TEST_F(ReceivedSamplesTest, ContentFilter_KeepsOutSamplesAndTheEndsOfTheirInstances) {
  ReceivedSamples samples(qos, type);
  auto above = filter("value > 10");
  EXPECT_EQ(take(samples, change("low", 10), &above), Outcome::unseen);
  EXPECT_EQ(take(samples, change("high", 11), &above), Outcome::stored);
  auto end = change("low");
  end.status.disposed = true;
  EXPECT_EQ(take(samples, end, &above), Outcome::unseen);
  end = change("high");
  end.status.disposed = true;
  EXPECT_EQ(take(samples, end, &above), Outcome::stored);
  EXPECT_EQ(samples.cache().instances(), 1u);
  EXPECT_EQ(samples.malformed(), 0u);
}

TEST_F(ReceivedSamplesTest, WithHistory_ASampleOfTwoWriters_IsTakenOnce) {
  for (const bool expects : {false, true}) {
    ReceivedSamples samples(qos, type);
    if (expects) samples.expect_history();
    auto first = change("kitchen", 1), again = first;
    again.writer = guid_of(2);
    again.original = {first.writer, first.sequence_number};
    EXPECT_EQ(take(samples, first), Outcome::stored);
    EXPECT_EQ(take(samples, again), expects ? Outcome::unseen : Outcome::stored);
  }
}

// A durability service (3) gives what the strong writer (1) wrote, in its name.
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
  EXPECT_EQ(take(*samples, kept(strong)), Outcome::stored);
  EXPECT_EQ(take(*samples, strong), Outcome::unseen) << "it is there already";
  EXPECT_EQ(take(*samples, of_weak(2)), Outcome::unseen) << "a stronger writer owns the instance";
  samples->cache().lose_writer(guid_of(1), true, now);
  EXPECT_EQ(take(*samples, of_weak(3)), Outcome::stored) << "the owner is gone";
}

TEST_F(ExclusiveSamplesTest, KeptSamplesThatAWeakerWriterReplaced_ComeAgainFromTheirWriter) {
  const auto first = change("kitchen", 1), second = change("kitchen", 2);
  EXPECT_EQ(take(*samples, kept(first)), Outcome::stored);
  EXPECT_EQ(take(*samples, kept(second)), Outcome::stored);
  EXPECT_EQ(take(*samples, of_weak(3)), Outcome::stored) << "no stronger writer is known to live";
  EXPECT_EQ(take(*samples, first), Outcome::stored);
  EXPECT_EQ(take(*samples, second), Outcome::stored);
  EXPECT_EQ(take(*samples, second), Outcome::unseen);
  EXPECT_EQ(take(*samples, of_weak(4)), Outcome::unseen);
}

TEST_F(ReceivedSamplesTest, NoRoom_IsRejected_AndTakenWhenThereIsSome) {
  qos.resource_limits.max_samples = 1;
  ReceivedSamples samples(qos, type);
  samples.expect_history();
  EXPECT_EQ(take(samples, change("a")), Outcome::stored);
  const auto second = change("a");
  EXPECT_EQ(take(samples, second), Outcome::rejected);
  std::vector<OctetSample> out;
  samples.cache().select({.take = true}, {now, Time::from(now)}, out);
  EXPECT_EQ(take(samples, second), Outcome::stored);
}

TEST_F(ReceivedSamplesTest, Reset_OtherPolicies_Count) {
  ReceivedSamples samples(qos, type);
  qos.resource_limits.max_samples = 1;
  samples.reset(qos);
  EXPECT_EQ(take(samples, change("a")), Outcome::stored);
  EXPECT_EQ(take(samples, change("a")), Outcome::rejected);
}

// -- ReaderPresentation

struct Presented final : PresentedReader {
  std::vector<std::int64_t> seen;
  KeyHash instance_of(const Change&) const override { return {}; }
  Room room_for(const WantedRoom&, const Guid&) const override { return Room::now; }
  bool present(Change& change) override {
    seen.push_back(change.sequence_number.value);
    return true;
  }
  void left(const Guid&) override {}
  void lose(std::size_t) override {}
  void give_up(const Guid&, std::size_t, Limit) override {}
};

struct ReaderPresentationTest : ::testing::Test {
  Presented reader;
  ReaderPresentation presentation{reader};
  const MonotonicTime now = std::chrono::seconds(1);

  static Presentation policy(PresentationScope scope, bool coherent, bool ordered) {
    return {.scope = scope, .coherent_access = coherent, .ordered_access = ordered};
  }
  bool put(std::int64_t number, std::int64_t set) {
    Change change;
    change.writer = guid_of(1);
    change.sequence_number = {number};
    change.coherence.set = {set};
    if (set > 0) change.payload = Payload::copy_of(Bytes{1});
    return presentation.on_change(change, now);
  }
};

TEST_F(ReaderPresentationTest, OrderedAlone_HoldsNothingBack) {
  presentation.start(policy(PresentationScope::topic, false, true), nullptr, false, now);
  EXPECT_FALSE(presentation.holds_back());
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  presentation.release(now);
  presentation.stop(now);
  EXPECT_EQ(presentation.next_tick(), kNever);
}

TEST_F(ReaderPresentationTest, Coherent_SetComesWhenItIsWhole) {
  presentation.start(policy(PresentationScope::topic, true, false), nullptr, false, now);
  ASSERT_TRUE(presentation.holds_back());
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1) && put(2, 1));
  EXPECT_THAT(reader.seen, IsEmpty());
  EXPECT_TRUE(put(3, 0));
  EXPECT_THAT(reader.seen, ElementsAre(1, 2));
}

TEST_F(ReaderPresentationTest, StartedBetweenBeginAndEndAccess_WaitsForItsEnd) {
  presentation.start(policy(PresentationScope::topic, true, false), nullptr, true, now);
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1) && put(2, 0));
  EXPECT_THAT(reader.seen, IsEmpty());
  presentation.pause(false, now);
  presentation.release(now);
  EXPECT_THAT(reader.seen, ElementsAre(1));
}

TEST_F(ReaderPresentationTest, GroupScope_UsesTheSubscribersPresenter) {
  Presenter of_group(true, true, false);
  presentation.start(policy(PresentationScope::group, true, false), &of_group, false, now);
  EXPECT_TRUE(presentation.holds_back());
  presentation.pause(true, now);  // not its own
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1));
  EXPECT_GT(of_group.octets(), 0u);
  presentation.stop(now);
  EXPECT_EQ(of_group.octets(), 0u);
}

// -- Parts that change statuses

struct Bare final : Entity {
  explicit Bare(ParticipantContext& context) : Entity(context) {}
  Status enable() override { return {}; }
  using Entity::changes_;
};

struct StatusChangesTest : ::testing::Test, UnservedContext {
  Bare entity{context};
};

TEST_F(StatusChangesTest, Noted_TriggersItsCondition_UntilCleared) {
  auto& condition = entity.status_condition();
  entity.changes_.note(StatusKind::sample_lost);
  EXPECT_TRUE(condition.trigger_value());
  EXPECT_TRUE(entity.changes_.contains(StatusKind::sample_lost));
  condition.set_enabled_statuses(StatusKind::sample_rejected);
  EXPECT_FALSE(condition.trigger_value());
  condition.set_enabled_statuses(kAnyStatus);
  EXPECT_TRUE(condition.trigger_value());
  entity.changes_.clear(StatusKind::sample_lost);
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_FALSE(entity.changes_.contains(StatusKind::sample_lost));
}

struct Asserted final : EndpointListener {
  std::vector<Guid> alive;
  void on_matched(const EndpointData&) override {}
  void on_unmatched(const Guid&) override {}
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_alive(const Guid& writer) override { alive.push_back(writer); }
};

struct RequestedLivelinessTest : StatusChangesTest {
  TimerQueue timers;
  Asserted reader;
  std::vector<Guid> lost;
  RequestedLiveliness liveliness{timers, reader, entity.changes_,
                                 [this](std::span<const Guid> writers, MonotonicTime) {
                                   lost.assign(writers.begin(), writers.end());
                                 }};
};

TEST_F(RequestedLivelinessTest, LeasesThatEnd_AreReportedTogether) {
  const auto lease = Duration::from(milliseconds(100));
  liveliness.add_writer(guid_of(1), lease, milliseconds(0));
  liveliness.add_writer(guid_of(2), lease, milliseconds(0));
  liveliness.add_writer(guid_of(3), lease, milliseconds(0));
  liveliness.on_alive(guid_of(3), milliseconds(90));
  EXPECT_EQ(liveliness.read_status().alive_count_change, 3);
  timers.run(milliseconds(100));
  EXPECT_THAT(lost, ElementsAre(guid_of(1), guid_of(2)));
  EXPECT_TRUE(entity.changes_.contains(StatusKind::liveliness_changed));
  const auto status = liveliness.read_status();
  EXPECT_EQ(status.alive_count, 1);
  EXPECT_EQ(status.not_alive_count_change, 2);
  EXPECT_FALSE(entity.changes_.contains(StatusKind::liveliness_changed));
  liveliness.stop();
  EXPECT_EQ(timers.next(), kNever);
}

TEST_F(RequestedLivelinessTest, WriterThatIsNotAlive_WaitsForItsSignal) {
  const auto signal = std::make_shared<LivelinessSignal>(milliseconds(0));
  liveliness.add_writer(guid_of(1), Duration::from(milliseconds(100)), milliseconds(0));
  liveliness.on_signal(guid_of(1), signal);
  timers.run(milliseconds(100));
  EXPECT_THAT(lost, ElementsAre(guid_of(1)));
  signal->assert_at(milliseconds(150));
  EXPECT_THAT(reader.alive, ElementsAre(guid_of(1)));
}

// -- DataReaderListeners

TEST(DataReaderListenersTest, DataOnReaders_ComesInsteadOfDataAvailable) {
  struct OfSubscriber final : SubscriberListener {
  } of_subscriber;
  struct OfParticipant final : DomainParticipantListener {
  } of_participant;
  Listening<SubscriberListener> subscriber;
  Listening<DomainParticipantListener> participant;
  const DataReaderListeners listeners(subscriber, participant);
  EXPECT_FALSE(listeners.has(StatusKind::data_available));
  participant = {&of_participant, StatusKind::data_on_readers};
  EXPECT_TRUE(listeners.has(StatusKind::data_available));
  EXPECT_EQ(listeners.for_status(StatusKind::data_available), nullptr);
  EXPECT_EQ(listeners.for_data_on_readers(), &of_participant);
  subscriber = {&of_subscriber, kAnyStatus};
  EXPECT_EQ(listeners.for_data_on_readers(), &of_subscriber);
  EXPECT_EQ(listeners.for_status(StatusKind::data_available), &of_subscriber);
}

// -- ReadConditions

struct ReadConditionsTest : Polled {};

TEST_P(ReadConditionsTest, Update_TriggersThoseThatFindSomething) {
  auto& reader = a.reader(reliable());
  const auto type = type_support<Reading>();
  ReadConditions conditions(reader, type);
  ReceivedSamples samples(reliable(), type);
  auto& any = conditions.create({});
  auto& high = **conditions.create({}, {"value > 10", {}});
  auto& every = **conditions.create({}, {" ", {}});
  EXPECT_EQ(code_of(conditions.create({}, {"no_such > 10", {}})), Code::rtps_filter_invalid);
  EXPECT_EQ(conditions.size(), 3u);
  Bytes octets;
  serialize(Reading{.sensor = "one", .value = 10}, octets);
  Change change;
  change.writer = guid_of(1);
  change.payload = Payload::copy_of(octets);
  samples.take(change, nullptr, {}, {clock.monotonic(), {}});
  conditions.update(samples.cache());
  EXPECT_TRUE(any.trigger_value() && every.trigger_value());
  EXPECT_FALSE(high.trigger_value());
  EXPECT_TRUE(any.check_reader(reader));
  EXPECT_EQ(code_of(any.check_reader(b.reader(reliable()))), Code::rtps_precondition_not_met);
}

TEST_P(ReadConditionsTest, Erase_KnowsItsOwnOnly) {
  auto& reader = a.reader(reliable());
  const auto type = type_support<Reading>();
  ReadConditions conditions(reader, type), others(reader, type);
  auto& one = conditions.create({});
  EXPECT_EQ(code_of(others.erase(one)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(conditions.erase(one));
  EXPECT_EQ(conditions.size(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Over, ReadConditionsTest, ::testing::Values(Way::in_process),
                         [](const auto& info) { return testing::name_of(info); });

}  // namespace
}  // namespace ddssec::rtps
