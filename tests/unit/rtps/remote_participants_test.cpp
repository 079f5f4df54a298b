// Remote participants that are forgotten.
#include "rtps/participant/remote_participants.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

// Ignores at once everything that it is notified of.
struct Ignorer final : DiscoveryListener {
  explicit Ignorer(RtpsParticipant& participant) : own(participant) {}
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
  RtpsParticipant& own;
  bool participants = false, endpoints = false, topics = false;
  int told = 0;
};

// Under the address sanitizer, this shows that nothing is used after it was forgotten.
TEST(Participant, WhatAListenerIgnores_IsForgottenWhenTheCallIsOver) {
  for (const int kind : {0, 1, 2, 3})
    for (const bool listens_first : {true, false}) {
      Node a(1), b(2);
      World world{{&a, &b}};
      Ignorer ignorer(b.participant);
      ignorer.participants = kind == 0 || kind == 3;
      ignorer.endpoints = kind == 1 || kind == 3;
      ignorer.topics = kind == 2 || kind == 3;
      if (listens_first) b.participant.set_discovery_listener(&ignorer);
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(
            a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
        ASSERT_TRUE(
            b.participant.create_reader(square(default_reader_qos()), b.listener, world.now));
        world.run();
      }
      if (!listens_first) b.participant.set_discovery_listener(&ignorer);
      world.run();
      EXPECT_GT(ignorer.told, 0);
      EXPECT_EQ(b.listener.matched, 0);
      EXPECT_EQ(b.participant.remote_participants().size(), ignorer.participants ? 0u : 1u);
      b.participant.set_discovery_listener(nullptr);
    }
}

// An attacker invents participants whose leases end together. Their removal costs about 1,400
// branches each, so other work comes between.
TEST(Participant, ManyLeasesThatEndTogether_AreHandledInTurns) {
  Node b(2);
  const auto now = std::chrono::seconds(1);
  constexpr std::size_t kCount = RemoteParticipants::kMaxEndsAtOnce + 10;
  for (std::uint8_t i = 0; i < kCount; ++i) {
    const auto prefix = GuidPrefix::from(Bytes(12, static_cast<std::uint8_t>(100 + i)));
    b.participant.receive(announcement(prefix, prefix), now);
  }
  const auto& remotes = b.participant.remote_participants();
  ASSERT_EQ(remotes.size(), kCount);
  const auto later = now + std::chrono::hours(1);
  b.participant.tick(later);
  EXPECT_EQ(remotes.size(), 10u);
  EXPECT_LE(b.participant.next_tick(), later);
  b.participant.tick(later);
  EXPECT_EQ(remotes.size(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps::participants
