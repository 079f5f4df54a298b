// Two participants without sockets: discovery, matching, and what they make of forged messages.
#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::code_of;
using testing::message;
using testing::written;
using testing::socketless::Node;
using testing::socketless::World;

EndpointRequest square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

Payload payload() { return Payload::copy_of(Bytes{0, 1, 0, 0, 1, 2, 3, 4}); }

Bytes announcement(const GuidPrefix& claimed, const GuidPrefix& source) {
  ParticipantData data;
  data.guid = {claimed, kEntityIdParticipant};
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7009)};
  data.builtin_endpoints = builtin_endpoints::kWithoutSecurity;
  std::array<std::uint8_t, 1024> buffer{};
  SpanWriter payload(buffer);
  write_payload(payload, data);
  auto octets = message(
      {written(Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()})});
  std::ranges::copy(source.octets, octets.begin() + 8);
  return octets;
}

TEST(Participant, FindsOthersMatchesAndDelivers) {
  Node a(1), b(2);
  World world{{&a, &b}};
  const auto writer =
      *a.participant.create_writer(square(default_writer_qos()), a.listener, world.now);
  world.run();
  const auto reader =
      *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, 1);
  EXPECT_EQ(b.listener.matched, 1);
  Change change;
  change.payload = payload();
  a.participant.local_endpoints().writer(writer)->write(change, world.now);
  world.run();
  ASSERT_EQ(b.listener.changes.size(), 1u);
  EXPECT_EQ(b.listener.changes[0].writer, writer);
  EXPECT_TRUE(a.events.seen.empty());
  EXPECT_TRUE(b.events.seen.empty());
  b.participant.remove(reader, world.now);
  world.run();
  EXPECT_EQ(a.listener.matched, 0);
  a.participant.leave();
  world.run(1);
  EXPECT_EQ(b.participant.remote_participants().size(), 0u);
  EXPECT_EQ(b.participant.counters().malformed, 0u);
}

// What waits to be read may be the answer.
TEST(Participant, NothingIsDueBeforeABacklogIsRead) {
  Node a(1);
  a.participant.note_backlog(true);
  a.participant.tick(seconds(1));
  EXPECT_TRUE(a.post.sent.empty());
  a.participant.tick(seconds(1));
  EXPECT_FALSE(a.post.sent.empty()) << "there was nothing more to read";
  a.post.sent.clear();
  for (unsigned i = 0; i < 2 * Participant::kMaxBacklog; ++i) {
    a.participant.note_backlog(true);
    a.participant.tick(seconds(2 + i));
  }
  EXPECT_EQ(a.post.sent.size(), 2u * 3u) << "now and then, whatever waits: to three addresses";
  a.participant.note_backlog(true);
  a.participant.note_backlog(false);
  a.post.sent.clear();
  a.participant.tick(seconds(90));
  EXPECT_FALSE(a.post.sent.empty());
}

TEST(Participant, AWritersLeaseOfNoTimeCausesNoEndlessWork) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto qos = default_writer_qos();
  qos.liveliness.lease_duration = Duration{{0, 1}};
  ASSERT_TRUE(a.participant.create_writer(square(qos), a.listener, world.now));
  world.run();
  int ticks = 0;
  for (auto now = world.now; now < world.now + seconds(1) && ticks < 20'000; ++ticks) {
    now = std::max(now, a.participant.next_tick());
    a.participant.tick(now);
  }
  EXPECT_LT(ticks, 5000);
}

TEST(Participant, ASilentParticipantIsGoneAfterItsLease) {
  Node a(1), b(2);
  World world{{&a, &b}};
  const auto writer =
      a.participant.create_writer(square(default_writer_qos()), a.listener, world.now);
  const auto reader =
      b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(reader);
  world.run();
  EXPECT_EQ(b.listener.matched, 1);
  world.nodes = {&b};
  world.now += seconds(9);
  world.run(1);
  EXPECT_EQ(b.listener.matched, 1);
  world.now += seconds(2);
  world.run(1);
  EXPECT_EQ(b.listener.matched, 0);
  EXPECT_EQ(b.participant.remote_participants().size(), 0u);
}

TEST(Participant, WhoIsIdleKeepsAShortLeaseThoughAnnouncementsAreLost) {
  Node a(1, 0, {}, 1), b(2);
  World world{{&a, &b}};
  world.run();
  for (int i = 0; i < 1000; ++i) {
    if (i % 100 < 60) a.post.sent.clear();  // more than half of each second
    world.run(1);
    ASSERT_EQ(b.participant.remote_participants().size(), 1u) << "after " << i * 10 << " ms";
  }
}

// Fast DDS announces itself before it listens: our first answer is lost.
TEST(Participant, ANewParticipantIsAnsweredASecondTimeSoon) {
  Node a(1), b(2);
  World world{{&a}};
  world.run(200);  // its quick announcements are over
  world.nodes = {&a, &b};
  int steps = 0;
  const auto begin = world.now;
  for (; b.participant.remote_participants().size() == 0 && steps < 300; ++steps) {
    if (world.now < begin + milliseconds(100)) a.post.sent.clear();
    world.run(1);
  }
  EXPECT_LE(steps, 60);
}

/// Ignores whatever it is told of, at once.
struct Ignorer final : DiscoveryListener {
  explicit Ignorer(Participant& participant) : own(participant) {}
  void on_participant(const ParticipantData& data) override { ignore(data.guid, participants); }
  void on_participant_gone(const Guid& guid) override { ignore(guid, participants); }
  void on_endpoint(const EndpointData& data) override {
    if (topics) own.ignore_topic(data.topic_name);
    ignore(data.guid, endpoints && participants);
  }
  void on_endpoint_gone(const EndpointData& data) override { on_endpoint(data); }
  void ignore(const Guid& guid, bool whole) {
    ++told;
    if (whole) own.ignore_participant(guid.prefix);
    if (endpoints) own.ignore_endpoint(guid);
  }
  Participant& own;
  bool participants = false, endpoints = false, topics = false;
  int told = 0;
};

// Under the address sanitizer: nothing is touched after it was forgotten.
TEST(Participant, WhatAListenerIgnoresIsForgottenWhenTheCallIsOver) {
  for (const int kind : {0, 1, 2, 3})
    for (const bool listens_first : {true, false}) {
      Node a(1), b(2);
      World world{{&a, &b}};
      Ignorer ignorer(b.participant);
      ignorer.participants = kind == 0 || kind == 3;
      ignorer.endpoints = kind == 1 || kind == 3;
      ignorer.topics = kind == 2 || kind == 3;
      if (listens_first) b.participant.listen(&ignorer);
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(
            a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
        ASSERT_TRUE(
            b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
        world.run();
      }
      if (!listens_first) b.participant.listen(&ignorer);
      world.run();
      EXPECT_GT(ignorer.told, 0);
      EXPECT_EQ(b.listener.matched, 0);
      EXPECT_EQ(b.participant.remote_participants().size(), ignorer.participants ? 0u : 1u);
      b.participant.listen(nullptr);
    }
}

TEST(Participant, OtherDomainsAndTagsAreNotSeen) {
  Node a(1), other_domain(2, 1), other_tag(3, 0, "tag");
  World world{{&a, &other_domain, &other_tag}};
  world.run();
  for (auto* node : world.nodes) EXPECT_EQ(node->participant.remote_participants().size(), 0u);
}

TEST(Participant, ANonMatchIsAStatusAndAnEventWithBothValues) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto offered = default_writer_qos();
  offered.reliability.kind = ReliabilityKind::best_effort;
  auto requested = default_reader_qos();
  requested.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(a.participant.create_writer(square(offered), a.listener, world.now));
  ASSERT_TRUE(b.participant.create_reader(square(requested), b.listener, world.now));
  world.run();
  for (auto* node : {&a, &b}) {
    ASSERT_EQ(node->listener.mismatches.size(), 1u);
    EXPECT_EQ(node->listener.mismatches[0].policy, "RELIABILITY.kind");
    ASSERT_THAT(node->events.codes(), ::testing::ElementsAre(Code::rtps_qos_incompatible));
    EXPECT_EQ(node->events.seen[0].error.details().found, "offered BEST_EFFORT");
    EXPECT_EQ(node->events.seen[0].error.hint(),
              "set RELIABILITY.kind of the writer to RELIABLE, or of the reader to BEST_EFFORT");
    EXPECT_EQ(node->listener.matched, 0);
  }
}

TEST(Participant, OtherTypesAndKeysAreNamed) {
  for (auto other : {EndpointRequest{"Square", "Other", default_reader_qos(), true},
                     EndpointRequest{"Square", "ShapeType", default_reader_qos(), false}}) {
    Node a(1), b(2);
    World world{{&a, &b}};
    ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
    ASSERT_TRUE(b.participant.create_reader(other, b.listener, world.now));
    world.run();
    EXPECT_THAT(a.events.codes(), ::testing::ElementsAre(Code::rtps_type_mismatch));
    EXPECT_EQ(a.listener.matched, 0);
    EXPECT_EQ(a.listener.inconsistent, 1);
  }
}

TEST(Participant, ChangedPoliciesAreAnnouncedAndMatchedAnew) {
  Node a(1), b(2);
  World world{{&a, &b}};
  auto offered = default_writer_qos();
  const auto writer = *a.participant.create_writer(square(offered), a.listener, world.now);
  const auto reader =
      *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now);
  world.run();
  EXPECT_THAT(b.participant.local_endpoints().matched(reader), ::testing::ElementsAre(writer));
  EXPECT_THAT(a.participant.local_endpoints().matched(writer), ::testing::ElementsAre(reader));
  offered.ownership_strength = 7;
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(b.listener.announced.back().ownership_strength, 7);
  EXPECT_EQ(b.listener.matched, 1);
  ASSERT_NE(b.participant.remote_participants().endpoint(writer), nullptr);
  EXPECT_EQ(b.participant.remote_participants().endpoint(writer)->qos.ownership_strength, 7);
  offered.partition = {"elsewhere"};
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched + b.listener.matched, 0);
  offered.partition = {};
  ASSERT_TRUE(a.participant.change_qos(writer, offered, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched + b.listener.matched, 2);
  offered.history.depth = 0;
  EXPECT_EQ(code_of(a.participant.change_qos(writer, offered, world.now)),
            Code::rtps_qos_inconsistent);
}

// By what one identity matches, it could make each write of ours as slow as it liked.
TEST(Participant, OneIdentityMatchesABoundedNumberOfTimesWithOneEndpoint) {
  Node a{1}, b{2}, c{3};
  World world{{&a, &b, &c}};
  ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
  std::vector<Guid> readers;
  constexpr int kMax = MatchTable::kMaxOfOne;
  for (int i = 0; i < kMax + 50; ++i)
    readers.push_back(
        *b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
  for (int i = 0; i < 300; ++i) world.run(1);
  EXPECT_EQ(a.listener.matched, kMax);
  EXPECT_EQ(a.participant.counters().refused_discovery, 50u);
  EXPECT_THAT(a.events.codes(), ::testing::ElementsAre(Code::rtps_too_many_endpoints));
  ASSERT_TRUE(c.participant.create_reader(square(default_reader_qos()), c.listener, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched, kMax + 1) << "another one's";
  for (int i = 0; i < 10; ++i)
    b.participant.remove(readers[static_cast<std::size_t>(i)], world.now);
  ASSERT_TRUE(b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
  world.run();
  EXPECT_EQ(a.listener.matched, kMax + 1 - 10 + 1);
}

// Datagrams to services of this machine, for whoever can send one announcement.
TEST(Participant, LoopbackAddressesCountOnlyIfTheyAreAnnouncedHere) {
  const auto at = [](const char* address) { return *Locator::parse(address, 7009); };
  auto config = Node::config(1, 0, {}, 10);
  config.interfaces = {{"eth0", at("192.0.2.1"), 24, true}};
  for (const auto* source : {"192.0.2.9", "127.0.0.1", "192.0.2.1"}) {
    Node::Post post;
    testing::socketless::Events events;
    Participant participant(config, post, events);
    const auto other = GuidPrefix::from(Bytes(12, 7));
    participant.receive(announcement(other, other), seconds(1), at(source));
    const bool here = std::string_view(source) != "192.0.2.9";
    EXPECT_EQ(participant.remote_participants().size(), here ? 1u : 0u) << source;
    EXPECT_EQ(post.sent.empty(), !here) << source;
  }
}

struct ParticipantLiveliness : ::testing::Test {
  Node a{1}, b{2};
  World world{{&a, &b}};
  Guid writer;
  void match(LivelinessKind kind) {
    auto offered = default_writer_qos();
    offered.liveliness = {kind, Duration{{1, 0}}};
    writer = *a.participant.create_writer(square(offered), a.listener, world.now);
    ASSERT_TRUE(b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
    world.run();
    ASSERT_EQ(b.listener.matched, 1);
    b.listener.alive.clear();
  }
};

TEST_F(ParticipantLiveliness, AutomaticComesWithAnyMessage) {
  match(LivelinessKind::automatic);
  b.participant.receive(announcement(a.participant.prefix(), a.participant.prefix()), world.now);
  EXPECT_THAT(b.listener.alive, ::testing::ElementsAre(writer));
}

TEST_F(ParticipantLiveliness, ManualComesWithSamplesAlone) {
  for (auto kind : {LivelinessKind::manual_by_participant, LivelinessKind::manual_by_topic}) {
    match(kind);
    b.participant.receive(announcement(a.participant.prefix(), a.participant.prefix()), world.now);
    EXPECT_TRUE(b.listener.alive.empty());
    Change change;
    change.payload = payload();
    a.participant.local_endpoints().writer(writer)->write(change, world.now);
    world.run(2);
    EXPECT_THAT(b.listener.alive, ::testing::Contains(writer));
    a.participant.remove(writer, world.now);
    world.run();
  }
}

TEST_F(ParticipantLiveliness, ManualByTopicComesWithAHeartbeatThatSaysSo) {
  match(LivelinessKind::manual_by_topic);
  a.participant.local_endpoints().writer(writer)->assert_liveliness();
  world.run(2);
  EXPECT_THAT(b.listener.alive, ::testing::ElementsAre(writer));
}

TEST(Participant, InconsistentQosIsRefused) {
  Node a(1);
  auto qos = default_writer_qos();
  qos.history.depth = 0;
  EXPECT_EQ(code_of(a.participant.create_writer(square(qos), a.listener, {})),
            Code::rtps_qos_inconsistent);
}

TEST(Participant, NobodyAnnouncesOrDisposesAnother) {
  Node a(1), b(2);
  World world{{&a, &b}};
  world.run();
  ASSERT_EQ(a.participant.remote_participants().size(), 1u);
  const auto stranger = GuidPrefix::from(Bytes(12, 9));
  a.participant.receive(announcement(GuidPrefix::from(Bytes(12, 8)), stranger), world.now);
  EXPECT_EQ(a.participant.remote_participants().size(), 1u);
  EXPECT_EQ(a.participant.counters().refused_discovery, 1u);
  const Guid victim{b.participant.prefix(), kEntityIdParticipant};
  auto dispose = message({written(Data{
      kSpdpReader, kSpdpWriter, {9}, {victim.octets(), {true, true}}, PayloadKind::none, {}})});
  std::ranges::copy(stranger.octets, dispose.begin() + 8);
  a.participant.receive(dispose, world.now);
  EXPECT_EQ(a.participant.remote_participants().size(), 1u);
}

TEST(Participant, MalformedMessagesAreCountedAndNamed) {
  Node a(1);
  auto broken = message({written(InfoDestination{})});
  std::ranges::fill(std::span(broken).subspan(8, 12), std::uint8_t{7});
  broken[22] = 200;
  a.participant.receive(broken, seconds(1));
  a.participant.receive(as_bytes("hello"), seconds(1));
  EXPECT_EQ(a.participant.counters().malformed, 2u);
  EXPECT_THAT(a.events.codes(),
              ::testing::ElementsAre(Code::rtps_submessage_overrun, Code::rtps_not_a_message));
}

}  // namespace
}  // namespace ddssec::rtps
