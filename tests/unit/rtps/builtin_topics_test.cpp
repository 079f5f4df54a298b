// Builtin topics, ignored entities, and searches.
#include "rtps/dcps/builtin_topics.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::reliable;
using testing::taken;

struct BuiltinTopicsTest : testing::Polled {
  template <class T>
  std::vector<BuiltinSample<T>> take() {
    std::vector<BuiltinSample<T>> out;
    EXPECT_TRUE(b.participant->builtin_datareader<T>()->take(out));
    return out;
  }
};

TEST_P(BuiltinTopicsTest, Participants_ComeChangeAndGo) {
  auto c = std::make_unique<testing::End>(services, options());
  Bytes user_data{1, 2};
  c->participant->set_qos({.user_data = user_data});
  const auto guid = c->participant->guid();
  const auto seen = [&] {
    c->participant->poll(0ms);
    const auto known = b.participant->discovered_participant_data(guid);
    return known && known->user_data == user_data;
  };
  ASSERT_TRUE(eventually(seen));
  EXPECT_EQ(b.participant->discovered_participants().size(), 2u);
  // The reader is made now, and gets what is known already.
  auto samples = take<ParticipantBuiltinTopicData>();
  ASSERT_EQ(samples.size(), 2u);
  user_data = {3};
  c->participant->set_qos({.user_data = user_data});
  ASSERT_TRUE(eventually(seen));
  samples = take<ParticipantBuiltinTopicData>();
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].data.guid, guid);
  EXPECT_EQ(samples[0].data.user_data, user_data);
  EXPECT_EQ(samples[0].info.view_state, ViewState::not_new);
  c.reset();
  run(50ms);
  samples = take<ParticipantBuiltinTopicData>();
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_FALSE(samples[0].info.valid_data);
  EXPECT_EQ(samples[0].data.guid, guid);
  EXPECT_EQ(code_of(b.participant->discovered_participant_data(guid)), Code::rtps_bad_parameter);
}

// An endpoint that matches must also be shown if its announcement is longer than 14,720 octets.
TEST_P(BuiltinTopicsTest, Endpoints_WithLongAnnouncements_AreShownWhole) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kMaxPartitions; ++i)
    names.push_back(std::to_string(i) + std::string(kMaxNameLength - 8, 'x'));
  auto* publisher = &a.participant->create_publisher({.partition = names});
  auto* subscriber = &a.participant->create_subscriber({.partition = names});
  auto qos = reliable();
  qos.user_data.assign(4000, 7);
  ASSERT_TRUE(publisher->create_datawriter<Reading>(*a.topic, qos));
  ASSERT_TRUE(subscriber->create_datareader<Reading>(*a.topic, qos));
  ASSERT_TRUE(eventually([&] { return b.participant->discovered_topics().size() == 1; }));
  run(50ms);
  const auto publications = take<PublicationBuiltinTopicData>();
  ASSERT_EQ(publications.size(), 1u);
  EXPECT_EQ(publications[0].data.qos.partition, names);
  EXPECT_EQ(publications[0].data.qos.user_data, qos.user_data);
  const auto subscriptions = take<SubscriptionBuiltinTopicData>();
  ASSERT_EQ(subscriptions.size(), 1u);
  EXPECT_EQ(subscriptions[0].data.qos.partition, names);
  EXPECT_EQ(take<TopicBuiltinTopicData>().size(), 1u);
}

TEST_P(BuiltinTopicsTest, EndpointsAndTheirTopics_ComeAndGo) {
  EXPECT_EQ(b.participant->builtin_subscriber().lookup_datareader("DCPSPublication"),
            b.participant->builtin_datareader<PublicationBuiltinTopicData>());
  auto qos = reliable();
  qos.user_data = {7};
  qos.deadline = Duration::from(1s);
  auto& writer = a.writer(qos);
  auto& reader = a.reader(reliable());
  b.writer(reliable());  // local endpoints are known without discovery
  ASSERT_TRUE(eventually([&] { return b.participant->discovered_topics().size() == 1; }));
  run();
  const auto publications = take<PublicationBuiltinTopicData>();
  ASSERT_EQ(publications.size(), 1u);
  EXPECT_EQ(publications[0].data.guid, writer.guid());
  EXPECT_EQ(publications[0].data.topic_name, "Readings");
  EXPECT_EQ(publications[0].data.qos.user_data, Bytes{7});
  EXPECT_EQ(publications[0].data.qos.deadline, qos.deadline);
  const auto subscriptions = take<SubscriptionBuiltinTopicData>();
  ASSERT_EQ(subscriptions.size(), 1u);
  EXPECT_EQ(subscriptions[0].data.guid, reader.guid());
  auto topics = take<TopicBuiltinTopicData>();
  ASSERT_EQ(topics.size(), 1u);
  EXPECT_EQ(topics[0].data.name, "Readings");
  EXPECT_EQ(topics[0].data.type_name, "Reading");

  ASSERT_TRUE(a.publisher->delete_datawriter(writer));
  run(50ms);
  const auto gone = take<PublicationBuiltinTopicData>();
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_EQ(gone[0].info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_EQ(gone[0].data.guid, publications[0].data.guid);
  EXPECT_THAT(take<TopicBuiltinTopicData>(), IsEmpty());  // because the reader still exists
  ASSERT_TRUE(a.subscriber->delete_datareader(reader));
  run(50ms);
  topics = take<TopicBuiltinTopicData>();
  ASSERT_EQ(topics.size(), 1u);
  EXPECT_EQ(topics[0].data.name, "Readings");
  EXPECT_EQ(topics[0].info.instance_state, InstanceState::not_alive_disposed);
  EXPECT_THAT(b.participant->discovered_topics(), IsEmpty());
}

// A reader from which the application takes nothing would hold its samples for nothing.
TEST_P(BuiltinTopicsTest, OnlyTheReaderThatIsAskedFor_IsMade) {
  EXPECT_THAT(take<PublicationBuiltinTopicData>(), IsEmpty());
  auto& gone = a.reader(reliable());
  auto& stays = a.reader(reliable());
  auto& writer = a.writer(reliable());
  ASSERT_TRUE(eventually([&] { return !b.participant->discovered_topics().empty(); }));
  run(50ms);
  ASSERT_TRUE(a.subscriber->delete_datareader(gone));
  run(50ms);
  const auto subscriptions = take<SubscriptionBuiltinTopicData>();
  ASSERT_EQ(subscriptions.size(), 1u) << "it knows nothing of before it was made";
  EXPECT_EQ(subscriptions[0].data.guid, stays.guid());
  const auto publications = take<PublicationBuiltinTopicData>();
  ASSERT_EQ(publications.size(), 1u);
  EXPECT_EQ(publications[0].data.guid, writer.guid());
  EXPECT_THAT(take<PublicationBuiltinTopicData>(), IsEmpty()) << "told once";
  EXPECT_EQ(take<TopicBuiltinTopicData>().size(), 1u);
}

// Without the bound, 40,000 of them took 600 MB, until the process ended.
TEST_P(BuiltinTopicsTest, EndpointsThatCameAndWent_TakeABoundedPlace) {
  std::vector<BuiltinSample<SubscriptionBuiltinTopicData>> out;
  auto* builtin = b.participant->builtin_datareader<SubscriptionBuiltinTopicData>();
  testing::End honest(services, options());
  const auto carry = [&] { run(), honest.participant->poll(0ms), run(); };
  auto& seen = honest.reader(reliable());
  const auto guid = seen.guid();
  const auto is_told = [&] {
    carry();
    EXPECT_TRUE(builtin->read(out));
    return std::ranges::any_of(out, [&](const auto& s) { return s.data.guid == guid; });
  };
  for (int i = 0; i < 500 && !is_told(); ++i) clock.advance(10ms);
  ASSERT_TRUE(honest.subscriber->delete_datareader(seen));
  auto qos = reliable();
  qos.user_data.assign(4096, 7);
  constexpr std::size_t kJunk = 300;
  for (std::size_t i = 0; i < kJunk; ++i) {
    auto& junk = a.reader(qos);
    carry();
    ASSERT_TRUE(a.subscriber->delete_datareader(junk));
    carry();
  }
  clock.advance(50ms), carry();
  EXPECT_TRUE(builtin->read(out));
  EXPECT_LT(out.size(), 2 * EndedInstances::kMaxOctetsPerIdentity / 4096 + 2);
  EXPECT_GT(out.size(), 40u) << "the latest are still told";
  EXPECT_TRUE(std::ranges::any_of(out, [&](const auto& sample) {
    return sample.data.guid == guid &&
           sample.info.instance_state == InstanceState::not_alive_disposed;
  })) << "what others withdrew is, too";
  EXPECT_TRUE(builtin->take(out));
  EXPECT_TRUE(builtin->read(out));
  EXPECT_THAT(out, IsEmpty());
}

TEST_P(BuiltinTopicsTest, Readers_StayAndAreOrdinaryOtherwise) {
  auto* reader = b.participant->builtin_datareader<ParticipantBuiltinTopicData>();
  auto& subscriber = b.participant->builtin_subscriber();
  EXPECT_EQ(code_of(subscriber.delete_datareader(*reader)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.participant->delete_subscriber(subscriber)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(reader->wait_for_historical_data(0ms));
  auto& condition = reader->create_readcondition({.sample = SampleState::not_read});
  EXPECT_EQ(condition.trigger_value(), b.participant->counters().remote_participants > 0);
  ASSERT_TRUE(eventually([&] { return condition.trigger_value(); }));
  take<ParticipantBuiltinTopicData>();
  EXPECT_FALSE(condition.trigger_value());
  EXPECT_THAT(reader->matched_publications(), IsEmpty());
  EXPECT_TRUE(reader->set_qos(reader->qos()));
}

TEST_P(BuiltinTopicsTest, AnIgnoredParticipant_IsAsIfItHadNeverBeen) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(b.participant->ignore_participant(a.participant->guid()));
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  ASSERT_TRUE(writer.write({"a", 1}));
  run(5000ms);  // it announces itself during this time
  EXPECT_THAT(b.participant->discovered_participants(), IsEmpty());
  EXPECT_THAT(taken(reader), IsEmpty());
}

TEST_P(BuiltinTopicsTest, OneEndpointOrOneTopic_MayBeIgnored) {
  auto& one = a.writer(reliable());
  auto& other = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(one, reader) && match(other, reader));
  ASSERT_TRUE(b.participant->ignore_publication(one.guid()));
  EXPECT_THAT(reader.matched_publications(), ElementsAre(other.guid()));
  ASSERT_TRUE(one.set_qos(one.qos()));  // announces it again
  run(50ms);
  EXPECT_THAT(reader.matched_publications(), ElementsAre(other.guid()));
  ASSERT_TRUE(a.participant->ignore_subscription(reader.guid()));
  EXPECT_THAT(other.matched_subscriptions(), IsEmpty());
  ASSERT_TRUE(b.participant->ignore_topic("Readings"));
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  a.writer(reliable());
  run(50ms);
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
}

// A listener of an application that ignores every participant and endpoint.
struct Hermit final : DataReaderListener {
  explicit Hermit(DomainParticipant& participant) : own(participant) {}
  void on_data_available(AnyDataReader&) override {
    std::vector<BuiltinSample<ParticipantBuiltinTopicData>> participants;
    EXPECT_TRUE(own.builtin_datareader<ParticipantBuiltinTopicData>()->take(participants));
    for (const auto& one : participants) ignore(one.data.guid);
    std::vector<BuiltinSample<PublicationBuiltinTopicData>> writers;
    EXPECT_TRUE(own.builtin_datareader<PublicationBuiltinTopicData>()->take(writers));
    for (const auto& one : writers) ignore(one.data.guid);
  }
  void ignore(const Guid& guid) {
    ++told;
    EXPECT_TRUE(own.ignore_publication(guid));
    EXPECT_TRUE(own.ignore_participant({guid.prefix, kEntityIdParticipant}));
  }
  DomainParticipant& own;
  int told = 0;
};

TEST_P(BuiltinTopicsTest, AParticipant_MayBeIgnoredByTheListenerThatHearsOfIt) {
  Hermit hermit(*b.participant);
  auto& reader = b.reader(reliable());
  b.participant->builtin_datareader<ParticipantBuiltinTopicData>()->set_listener(&hermit);
  b.participant->builtin_datareader<PublicationBuiltinTopicData>()->set_listener(&hermit);
  for (int i = 0; i < 3; ++i) a.writer(reliable());
  ASSERT_TRUE(eventually([&] { return hermit.told > 0; }));
  run(500ms);
  EXPECT_THAT(b.participant->discovered_participants(), IsEmpty());
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  b.participant->builtin_datareader<ParticipantBuiltinTopicData>()->set_listener(nullptr);
  b.participant->builtin_datareader<PublicationBuiltinTopicData>()->set_listener(nullptr);
}

TEST_P(BuiltinTopicsTest, OnesOwn_MayBeIgnored) {
  auto& writer = a.writer(reliable());
  auto& reader = a.reader(reliable());
  EXPECT_THAT(reader.matched_publications(), ElementsAre(writer.guid()));
  ASSERT_TRUE(a.participant->ignore_participant(a.participant->guid()));
  EXPECT_THAT(reader.matched_publications(), IsEmpty());
  EXPECT_THAT(writer.matched_subscriptions(), IsEmpty());
  EXPECT_THAT(a.reader(reliable()).matched_publications(), IsEmpty());
}

TEST_P(BuiltinTopicsTest, BeforeTheParticipantIsEnabled_NothingIsIgnored) {
  auto disabled = options();
  disabled.enabled = false;
  const auto participant = *DomainParticipant::create(disabled, services);
  EXPECT_EQ(code_of(participant->ignore_topic("x")), Code::rtps_not_enabled);
  EXPECT_EQ(code_of(participant->revise_keys()), Code::rtps_not_enabled);
}

TEST_P(BuiltinTopicsTest, ParticipantWithoutKeys_HasNoneToRevise) {
  EXPECT_EQ(code_of(a.participant->revise_keys()), Code::rtps_key_revision_disabled);
}

TEST_P(BuiltinTopicsTest, ATopic_IsFoundHereOrThere) {
  EXPECT_EQ(*a.participant->find_topic("Readings", 0ms), a.topic);
  // It must be deleted as often as it was created or found.
  EXPECT_TRUE(a.participant->delete_topic(*a.topic));
  EXPECT_NE(a.participant->lookup_topicdescription("Readings"), nullptr);
  EXPECT_EQ(code_of(a.participant->find_topic("Others", 1ms)), Code::rtps_timeout);
  auto& others = **b.participant->create_topic<Reading>("Others");
  auto& writer = **b.publisher->create_datawriter<Reading>(others, reliable());
  ASSERT_TRUE(eventually([&] { return !a.participant->discovered_topics().empty(); }));
  const auto found = a.participant->find_topic("Others", 0ms);
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)->type_name(), "Reading");
  auto& reader = **a.subscriber->create_datareader(**found, reliable());
  ASSERT_TRUE(match(writer, reader));
  ASSERT_TRUE(writer.write({"a", 1}));
  run(20ms);
  std::vector<OctetSample> samples;
  EXPECT_EQ(reader.take(samples), GetParam() == testing::Way::in_process ? 1u : 0u);
}

INSTANTIATE_TEST_SUITE_P(Over, BuiltinTopicsTest,
                         ::testing::Values(testing::Way::network, testing::Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
