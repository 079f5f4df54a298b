// Neither the discovery of a topic nor RTPS messages are protected. An attacker uses up the
// sequence numbers of announcements, so that genuine ones count as known (T60 in docs/attacks.md).
#include "tests/attack/rtps/forged_announcements.hpp"
#include "tests/attack/rtps/participant_access.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Participant a writes and b reads. Each test hides a second reader of b from a.
struct HiddenEndpoints : ForgedAnnouncements, ::testing::Test {
  HiddenEndpoints()
      : ForgedAnnouncements(Kind::readers_of_b,
                            {.discovery = ProtectionKind::encrypt, .clear_topics = true}) {}
  template <class Message>
  void send_to_a(const Message& message) {
    pair.a->receive(forged(pair.b->prefix(), message), pair.world.now, attacker);
  }
  // Announces in b's name a reader that does not exist.
  void invent(SequenceNumber number) {
    next = number.value;
    announce(forged_endpoint(0));
  }
  void claim(SequenceNumber first, SequenceNumber last) {
    send_to_a(Heartbeat{.reader = kSubscriptionsReader,
                        .writer = kSubscriptionsWriter,
                        .first = first,
                        .last = last,
                        .count = 1000});
  }
  Guid create_reader() {
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    return pair.b->create_reader(square(qos), pair.b.listener, pair.world.now).value();
  }
  bool is_found(const Guid& reader, std::chrono::seconds within) {
    return pair.world.run_until([&] { return matches(reader); }, static_cast<int>(within / 10ms));
  }
  const AnnouncementRefresh& refresh() const {
    return pair.a.participant->remote_participants()
        .all()
        .at(pair.b.participant->prefix())
        .announcement_refresh;
  }
  // The refreshes that begin within this time; `each_second` is called with the second.
  template <class F>
  int count_refreshes(std::chrono::seconds within, F each_second) {
    int refreshes = 0;
    bool was_under_way = false;
    for (int second = 0; second < within.count(); ++second) {
      each_second(second);
      pair.world.run(100);
      const bool is_under_way = refresh().is_under_way();
      refreshes += is_under_way && !was_under_way ? 1 : 0;
      was_under_way = is_under_way;
    }
    return refreshes;
  }

  const SequenceNumber hidden{2};  // the number of b's next announcement
};

constexpr auto kShort = 5s;  // AnnouncementRefresh::kMinPause, and some time for the answer
constexpr auto kOffer = 40s;

struct Forgery {
  const char* name;
  void (*send)(HiddenEndpoints& test);
};
constexpr Forgery kForgeries[] = {
    {"AnnouncementWithTheirNumber", [](auto& test) { test.invent(test.hidden); }},
    {"HeartbeatThatSkipsThem", [](auto& test) { test.claim({100001}, {100000}); }},
    {"HeartbeatThatSkipsOnlyThem", [](auto& test) { test.claim({3}, {2}); }},
    {"Gap",
     [](auto& test) {
       test.send_to_a(Gap{kSubscriptionsReader, kSubscriptionsWriter, test.hidden,
                          SequenceNumberSet(SequenceNumber{1000})});
     }},
};

struct HiddenByAForgery : HiddenEndpoints, ::testing::WithParamInterface<Forgery> {};
INSTANTIATE_TEST_SUITE_P(All, HiddenByAForgery, ::testing::ValuesIn(kForgeries),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(HiddenByAForgery, Endpoints_AreFoundByTheNextRefresh) {
  GetParam().send(*this);
  const auto reader = create_reader();
  pair.world.run(100);
  ASSERT_FALSE(matches(reader));
  EXPECT_TRUE(is_found(reader, kShort));
}

// The genuine announcement is lost, so nothing contradicts the forged one before b says what it
// has.
TEST_F(HiddenEndpoints, HeartbeatAfterALostAnnouncement_IsUndoneBeforeAnotherIsAnnounced) {
  pair.world.attack = [](World::Traffic& traffic) { traffic.clear(); };
  const auto reader = create_reader();
  claim({100001}, {100000});
  pair.b->receive(forged(pair.a->prefix(), AckNack{kSubscriptionsReader, kSubscriptionsWriter,
                                                   SequenceNumberSet(hidden.next()), 1000, true}),
                  pair.world.now, attacker);
  pair.world.run(10);
  pair.world.attack = {};
  pair.world.run(100);
  ASSERT_FALSE(matches(reader));
  EXPECT_TRUE(is_found(reader, kOffer));
}

// Participant b believes that a has the announcement.
TEST_F(HiddenEndpoints, ForgedAcknowledgment_IsUndoneByTheNextOffer) {
  pair.world.attack = [](World::Traffic& traffic) { traffic.clear(); };
  const auto reader = create_reader();
  pair.world.run(1);
  pair.b->receive(forged(pair.a->prefix(), AckNack{kSubscriptionsReader, kSubscriptionsWriter,
                                                   SequenceNumberSet(hidden.next()), 1000, true}),
                  pair.world.now, attacker);
  pair.world.run(10);
  pair.world.attack = {};
  pair.world.run(300);
  ASSERT_FALSE(matches(reader));
  EXPECT_TRUE(is_found(reader, kOffer));
}

// The forged announcement has the right number, the genuine one is lost, and b believes that a has
// it, so no message contradicts another one. Participants of other vendors do not repeat what they
// have announced.
TEST_F(HiddenEndpoints, WithoutAContradiction_AreFoundByTheNextRefresh) {
  ParticipantAccess::peer(*pair.b.participant, pair.a->prefix()).next_offer = kNever;
  pair.world.attack = [](World::Traffic& traffic) { traffic.clear(); };
  const auto reader = create_reader();
  invent(hidden);
  pair.world.run(1);
  pair.b->receive(forged(pair.a->prefix(), AckNack{kSubscriptionsReader, kSubscriptionsWriter,
                                                   SequenceNumberSet(hidden.next()), 1000, true}),
                  pair.world.now, attacker);
  pair.world.run(10);
  pair.world.attack = {};
  pair.world.run(6000);
  ASSERT_FALSE(matches(reader)) << "by chance, the next refresh came early";
  EXPECT_TRUE(is_found(reader, 256s + kShort));
}

// In the end the forgeries cost the peer one refresh in 256 s.
TEST_F(HiddenEndpoints, ForgeriesThatGoOn_CauseFewerAndFewerRefreshes) {
  const int refreshes = count_refreshes(600s, [this](int second) {
    invent({second % 2 == 0 ? 100 : 3 + second});
    claim({1}, {second % 50});
  });
  EXPECT_GE(refreshes, 3);
  EXPECT_LE(refreshes, 9) << "in 600 s";
}

// There is no forgery.
TEST_F(HiddenEndpoints, WhereNothingContradicts_EverythingIsReadSeldom) {
  const int refreshes = count_refreshes(1024s, [this](int second) {
    if (second % 20 == 0) create_reader();
  });
  EXPECT_GE(refreshes, 3);
  EXPECT_LE(refreshes, 9) << "in 1024 s";
  EXPECT_TRUE(matches(pair.reader));
  EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
