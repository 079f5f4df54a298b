// Ends of validity, returned handles and bounds.
#include <gmock/gmock.h>

#include "plugins/authentication/unproven_octets.hpp"
#include "tests/unit/authentication/fixture.hpp"

namespace ddssec::authentication {
namespace {

struct Ending {
  explicit Ending(pki::Validity of_bob = {kNow - 24h, kNow + 10s})
      : pairing(make_identity(test_ca(), "CN=alice,O=Example"),
                make_identity(test_ca(), "CN=bob,O=Example", {}, of_bob, 1)) {}
  void advance(std::chrono::seconds by) {
    pairing.first_engine.clock.advance(by);
    pairing.second_engine.clock.advance(by);
  }
  IdentityHandle bob_at_alice() const {
    return &pairing.two.low == &pairing.a ? pairing.two.high_at_low : pairing.two.low_at_high;
  }
  IdentityHandle alice_at_bob() const {
    return &pairing.two.low == &pairing.a ? pairing.two.low_at_high : pairing.two.high_at_low;
  }
  Pairing pairing;
};

TEST(Expiry, EndsLocalAndRemoteIdentitiesOnce) {
  Ending ending;
  auto& pairing = ending.pairing;
  EXPECT_EQ(pairing.first_engine->next_expiry(), kYear.not_after);
  pairing.expect_success();
  EXPECT_EQ(pairing.first_engine->next_expiry(), kNow + 10s);
  EXPECT_EQ(pairing.second_engine->next_expiry(), kNow + 10s);
  ending.advance(9s);
  EXPECT_TRUE(pairing.first_engine->expire().empty());
  EXPECT_TRUE(pairing.second_engine->expire().empty());
  ending.advance(1s);
  EXPECT_EQ(pairing.first_engine->expire(), std::vector{ending.bob_at_alice()});
  EXPECT_EQ(pairing.second_engine->expire(),
            (std::vector{pairing.b.handle, ending.alice_at_bob()}));
  EXPECT_TRUE(pairing.first_engine->expire().empty());
  EXPECT_TRUE(pairing.second_engine->expire().empty());
  EXPECT_EQ(pairing.first_engine->next_expiry(), kYear.not_after);

  ASSERT_EQ(pairing.first_engine.events.events.size(), 1u);
  const auto& event = pairing.first_engine.events.events[0];
  EXPECT_EQ(event.error.code(), Code::identity_ended);
  EXPECT_EQ(event.peer_subject, "CN=bob,O=Example");
  EXPECT_EQ(event.guid, pairing.b.guid.to_string());
  EXPECT_EQ(event.error.details().expected, "a time before 2026-11-21T00:00:10Z");
  EXPECT_EQ(event.error.details().document, "CN=bob,O=Example");
}

TEST(Expiry, AnEndedIdentityIsRefusedEverywhere) {
  Ending ending;
  auto& pairing = ending.pairing;
  pairing.expect_success();
  ending.advance(10s);
  pairing.first_engine->expire();
  pairing.second_engine->expire();
  EXPECT_CODE(pairing.a.discover(pairing.b), identity_ended);
  EXPECT_CODE(pairing.b.discover(pairing.a), identity_ended);
  EXPECT_CODE(pairing.two.request(), identity_ended);
  EXPECT_CODE(pairing.second_engine->identity_token(pairing.b.handle), identity_ended);
  // The clock set back does not bring it back: the host has cut it off.
  pairing.first_engine.clock.set(kNow);
  EXPECT_CODE(pairing.a.discover(pairing.b), identity_ended);
  ASSERT_OK(pairing.first_engine->return_identity_handle(ending.bob_at_alice()));
  EXPECT_TRUE(pairing.a.discover(pairing.b));
}

// T4: the calendar jumps; the next look at it counts.
TEST(Expiry, FollowsTheCalendarWhenItIsSet) {
  Ending ending({kNow - 24h, kNow + 1000h});
  auto& pairing = ending.pairing;
  pairing.expect_success();
  pairing.first_engine.clock.set(kNow - 12h);
  EXPECT_TRUE(pairing.first_engine->expire().empty());
  pairing.first_engine.clock.set(kNow + 1001h);
  EXPECT_EQ(pairing.first_engine->expire(), std::vector{ending.bob_at_alice()});
}

TEST(Expiry, EveryStepJudgesAgain) {
  for (int step = 0; step < 4; ++step) {
    Ending ending;
    auto& pairing = ending.pairing;
    auto& two = pairing.two;
    const auto tick = [&](int at) {
      if (at == step) ending.advance(10s);
    };
    tick(0);
    const auto req = two.request();
    tick(1);
    const auto rep = req ? two.reply(*req->message) : Two::Step(std::unexpected(req.error()));
    tick(2);
    const auto fin =
        rep ? two.at_low(req->handle, *rep->message) : Two::Step(std::unexpected(rep.error()));
    tick(3);
    const auto end =
        fin ? two.at_high(rep->handle, *fin->message) : Two::Step(std::unexpected(fin.error()));
    EXPECT_CODE(end, certificate_expired);
  }
}

TEST(Expiry, TheCasEndCounts) {
  const auto ca = make_ca("CN=Short CA", {}, {kNow - 24h, kNow + 5s});
  Engine engine;
  Participant alice(engine, make_identity(ca, "CN=alice"), 1);
  EXPECT_EQ(engine->next_expiry(), kNow + 5s);
  engine.clock.advance(5s);
  EXPECT_EQ(engine->expire(), std::vector{alice.handle});
  EXPECT_EQ(engine.events.events.at(0).error.details().document, "CN=Short CA");
}

// ---- handles

TEST(Handles, ThatWereNeverGivenOutOrReturnedAreRefused) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& engine = *two.low.engine;
  const HandshakeHandle nobody{99};
  EXPECT_CODE(engine->process_handshake(nobody, {}), unknown_handshake);
  EXPECT_CODE(engine->shared_secret(nobody), unknown_handshake);
  EXPECT_CODE(engine->authenticated_peer_credential_token(nobody), unknown_handshake);
  EXPECT_CODE(engine->return_handshake_handle(nobody), unknown_handshake);
  EXPECT_CODE(engine->return_identity_handle({99}), unknown_identity);
  EXPECT_CODE(engine->identity_token({99}), unknown_identity);
  EXPECT_CODE(engine->identity_status_token({}), unknown_identity);
  EXPECT_CODE(engine->begin_handshake_request(two.low.handle, {99}, two.low.data),
              unknown_identity);
  EXPECT_CODE(engine->begin_handshake_request({99}, two.high_at_low, two.low.data),
              unknown_identity);
  // A local handle is no remote one.
  EXPECT_CODE(engine->begin_handshake_request(two.low.handle, two.low.handle, two.low.data),
              unknown_identity);
}

TEST(Handles, ReturningTheRemoteDropsItsHandshakes) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& engine = *two.low.engine;
  const auto req = two.request();
  ASSERT_OK(req);
  ASSERT_OK(engine->return_identity_handle(two.high_at_low));
  EXPECT_CODE(two.at_low(req->handle, {}), unknown_handshake);
  EXPECT_CODE(engine->return_identity_handle(two.high_at_low), unknown_identity);
  EXPECT_CODE(two.request(), unknown_identity);
}

TEST(Handles, ReturningTheLocalDropsItsHandshakes) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& engine = *two.low.engine;
  const auto req = two.request();
  ASSERT_OK(req);
  ASSERT_OK(engine->return_identity_handle(two.low.handle));
  EXPECT_CODE(two.at_low(req->handle, {}), unknown_handshake);
  EXPECT_FALSE(engine->next_expiry());
}

TEST(Handles, ARemoteThatWasNotValidatedForThisLocalIsUnknown) {
  Pairing pairing;
  Participant second(*pairing.two.low.engine, make_identity(test_ca(), "CN=second"), 5);
  EXPECT_CODE((*pairing.two.low.engine)
                  ->begin_handshake_request(second.handle, pairing.two.high_at_low, second.data),
              unknown_identity);
}

// ---- bounds

TEST(Bounds, RemoteIdentities) {
  Engine engine(1, {.most_remote_identities = 3});
  Participant us(engine, make_identity(test_ca(), "CN=ours"), 1);
  const Token token{"DDS:Auth:PKI-DH:1.0"};
  for (std::uint8_t i = 0; i < 3; ++i)
    ASSERT_OK(engine->validate_remote_identity(us.handle, {}, token, candidate(0x80 + i)));
  EXPECT_CODE(engine->validate_remote_identity(us.handle, {}, token, candidate(0x90)),
              too_many_remote_identities);
  // Those that are known are not affected, and one that leaves makes room.
  const auto known = engine->validate_remote_identity(us.handle, {}, token, candidate(0x80));
  ASSERT_OK(known);
  ASSERT_OK(engine->return_identity_handle(known->handle));
  EXPECT_TRUE(engine->validate_remote_identity(us.handle, {}, token, candidate(0x90)));
}

/// A process whose participants share one certificate.
struct Fleet {
  explicit Fleet(const std::string& subject, std::uint64_t seed)
      : engine(seed), identity(make_identity(test_ca(), subject, {}, kYear, 1)) {}
  /// One more authenticates with `us`; the error of the call in which `us` refuses it.
  Result<IdentityHandle> join(Participant& us) {
    members.push_back(std::make_unique<Participant>(engine, identity,
                                                    static_cast<std::uint8_t>(members.size() + 1)));
    auto& member = *members.back();
    if (auto known = us.discover(member); !known) return std::unexpected(known.error());
    Two two(us, member);
    const bool we_begin = &two.low == &us;
    const auto request = two.request();
    const auto reply = two.reply(*request->message);
    const auto final = two.at_low(request->handle, *reply->message);
    if (!final) return std::unexpected(final.error());
    if (const auto end = two.at_high(reply->handle, *final->message); !end)
      return std::unexpected(end.error());
    return we_begin ? two.high_at_low : two.low_at_high;
  }
  Engine engine;
  Identity identity;
  std::vector<std::unique_ptr<Participant>> members;
};

TEST(Bounds, ACertificateThatFillsItsShareLeavesRoomForAnother) {
  Engine engine(1, {.most_remote_identities = 8, .most_identities_of_a_subject = 3});
  Participant us(engine, make_identity(test_ca(), "CN=ours"), 1);
  Fleet greedy("CN=greedy", 2), honest("CN=honest", 3);
  IdentityHandle last;
  for (int i = 0; i < 3; ++i) {
    const auto joined = greedy.join(us);
    ASSERT_OK(joined);
    last = *joined;
  }
  const auto refused = greedy.join(us);
  EXPECT_CODE(refused, too_many_identities_of_subject);
  EXPECT_TRUE(spi::refusal_passes(refused.error().code()));
  const auto& told = engine.events.events.back().error;
  EXPECT_NE(told.to_sentence().find("CN=greedy"), std::string::npos);
  EXPECT_NE(told.to_sentence().find("at most 3 participants"), std::string::npos);
  EXPECT_TRUE(honest.join(us));
  // One that leaves makes room.
  ASSERT_OK(engine->return_identity_handle(last));
  EXPECT_TRUE(greedy.join(us));
}

TEST(Bounds, NoSubjectTakesTheLastPlaces) {
  Engine engine(1, {.most_remote_identities = 8});
  Participant us(engine, make_identity(test_ca(), "CN=ours"), 1);
  std::vector<int> joined;
  for (std::uint64_t number = 2; number < 8; ++number) {
    Fleet fleet("CN=fleet " + std::to_string(number), number);
    joined.push_back(0);
    while (fleet.join(us)) ++joined.back();
  }
  EXPECT_EQ(joined, (std::vector{4, 2, 1, 1, 0, 0}));
  EXPECT_CODE(us.discover(Participant(engine, make_identity(test_ca(), "CN=one more"), 9)),
              too_many_remote_identities);
}

TEST(Bounds, InventedParticipantsAreCountedApart) {
  Engine engine(1, {.most_remote_identities = 4, .most_identities_of_a_subject = 4});
  Participant us(engine, make_identity(test_ca(), "CN=ours"), 1);
  Fleet fleet("CN=fleet", 2);
  std::vector<IdentityHandle> invented;
  const auto invent = [&](std::uint8_t number) -> Status {
    const auto known = engine->validate_remote_identity(us.handle, {}, {"DDS:Auth:PKI-DH:1.0"},
                                                        candidate(0x80 + number));
    if (!known) return std::unexpected(known.error());
    invented.push_back(known->handle);
    return {};
  };
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_OK(invent(i));
  // They leave no room but for one claim at a time; who proves one frees it.
  EXPECT_TRUE(fleet.join(us));
  EXPECT_TRUE(fleet.join(us));
  ASSERT_OK(invent(3));
  const auto refused = fleet.join(us);
  EXPECT_CODE(refused, too_many_remote_identities);
  EXPECT_TRUE(spi::refusal_passes(refused.error().code()));
  ASSERT_OK(engine->return_identity_handle(invented.back()));
  EXPECT_FALSE(fleet.join(us));  // two of four: no more than are free
  EXPECT_TRUE(Fleet("CN=another", 3).join(us));
}

TEST(Bounds, AShareIsCheckedAgainWhenAClaimIsProven) {
  Engine engine(1, {.most_identities_of_a_subject = 1});
  Participant us(engine, make_identity(test_ca(), "CN=ours"), 1);
  Fleet fleet("CN=fleet", 2);
  Participant first(fleet.engine, fleet.identity, 1), second(fleet.engine, fleet.identity, 2);
  Two with_first(us, first), with_second(us, second);
  const auto shake = [](Two& two) -> Status {
    const auto request = two.request();
    const auto reply = two.reply(*request->message);
    const auto final = two.at_low(request->handle, *reply->message);
    if (!final) return std::unexpected(final.error());
    const auto end = two.at_high(reply->handle, *final->message);
    return end ? Status() : std::unexpected(end.error());
  };
  ASSERT_OK(shake(with_first));
  EXPECT_CODE(shake(with_second), too_many_identities_of_subject);
  // Who is counted may authenticate again; and what is counted is forgotten with it.
  EXPECT_TRUE(shake(with_first));
  const bool we_begin = &with_first.low == &us;
  ASSERT_OK(
      engine->return_identity_handle(we_begin ? with_first.high_at_low : with_first.low_at_high));
  EXPECT_TRUE(shake(with_second));
}

TEST(Bounds, LocalIdentities) {
  Engine engine(1, {.most_local_identities = 1});
  const auto identity = make_identity(test_ca(), "CN=ours");
  Participant us(engine, identity, 1);
  EXPECT_CODE(engine->validate_local_identity(0, identity.properties, candidate(2)),
              too_many_local_identities);
}

/// A request that anybody could send who saw an honest one.
Token forged(const Token& request, std::uint8_t number) {
  return without(with(request, "challenge1", Bytes(32, number)), "hash_c1");
}

TEST(Bounds, PendingRepliesGiveWayToTheHonestOneInTime) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto req = two.request();
  for (std::uint8_t i = 0; i < kMostPendingPerPair; ++i)
    ASSERT_OK(two.reply(forged(*req->message, i)));
  EXPECT_CODE(two.reply(*req->message), too_many_handshakes);
  two.high.engine->clock.advance(kPendingAge);
  const auto rep = two.reply(*req->message);
  ASSERT_OK(rep);
  pairing.expect_finish(*req, *rep);
}

/// The same with permissions of that size, without a signature.
Token large(const Token& request, std::uint8_t number, std::size_t octets) {
  return with(forged(request, number), "c.perm", Bytes(octets, 'x'));
}

/// A stranger with a recorded request announces participants of its subject, and sends a request
/// with junk in the name of each.
class Stranger {
 public:
  Stranger(const Token& recorded, const Identity& recorded_identity, Participant& victim)
      : recorded_(recorded), identity_(recorded_identity), victim_(victim) {}

  /// The reply of the victim to that many octets of permissions.
  Two::Step sends(std::size_t octets) {
    const auto number = static_cast<std::uint8_t>(++sent_);
    Participant invented(engine_, identity_, number + 10);
    Two two(invented, victim_);
    return two.reply(with(large(recorded_, number, octets), "c.pdata", invented.data));
  }

 private:
  const Token recorded_;
  const Identity identity_;
  Participant& victim_;
  Engine engine_{9};
  int sent_ = 0;
};

/// The lower of the two has a document of that size, and a stranger knows its certificate.
struct LargeDocuments {
  explicit LargeDocuments(std::size_t octets)
      : alice(make_identity(test_ca(), "CN=alice,O=Example")),
        bob(make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1)),
        pairing(alice, bob) {
    Token credential{.class_id = std::string(spi::class_id::kPermissionsCredential)};
    credential.properties.push_back({"dds.perm.cert", std::string(octets, 'p'), false});
    EXPECT_TRUE(
        (*low().engine)->set_permissions_credential_and_token(low().handle, credential, {}));
    request = pairing.two.request();
  }
  Participant& low() { return pairing.two.low; }
  Stranger stranger() {
    return {*(*request)->message, &low() == &pairing.a ? alice : bob, pairing.two.high};
  }
  std::vector<Event>& events() { return pairing.two.high.engine->events.events; }

  Identity alice, bob;
  Pairing pairing;
  std::optional<Two::Step> request;
};

TEST(Bounds, OwnerOfLargeDocuments_GetsInWhileAStrangerFillsItsSubject) {
  for (const std::size_t size : {std::size_t{86'000}, kMostPermissionsOctets}) {
    LargeDocuments world(size);
    auto stranger = world.stranger();
    for (int i = 0; i < 12; ++i) ASSERT_OK(stranger.sends(kMostPermissionsOctets));
    const auto reply = world.pairing.two.reply(*(*world.request)->message);
    ASSERT_OK(reply);
    world.pairing.expect_finish(**world.request, *reply);
  }
}

// Each drop is a new draw: the owner is not the one that always goes.
TEST(Bounds, OwnerOfLargeDocuments_OutlivesSomeRequestsThatComeAfterIts) {
  int finished = 0;
  for (int turn = 0; turn < 8; ++turn) {
    LargeDocuments world(kMostPermissionsOctets);
    auto stranger = world.stranger();
    for (int i = 0; i < 10 + turn; ++i) ASSERT_OK(stranger.sends(kMostPermissionsOctets));
    const auto reply = world.pairing.two.reply(*(*world.request)->message);
    ASSERT_OK(reply);
    ASSERT_OK(stranger.sends(kMostPermissionsOctets));
    const auto final = world.pairing.two.at_low((*world.request)->handle, *reply->message);
    ASSERT_OK(final);
    finished += world.pairing.two.at_high(reply->handle, *final->message).has_value();
  }
  EXPECT_GE(finished, 4);
}

TEST(Bounds, DroppedRequestOfAStranger_IsAnEventWithTheLimits) {
  LargeDocuments world(86'000);
  auto stranger = world.stranger();
  for (int i = 0; i < 9; ++i) ASSERT_OK(stranger.sends(kMostPermissionsOctets));
  ASSERT_FALSE(world.events().empty());
  EXPECT_EQ(world.events().back().error.code(), Code::too_many_handshakes);
  EXPECT_THAT(world.events().back().error.to_sentence(),
              testing::HasSubstr("8388608 octets of a subject"));
}

TEST(Bounds, LargeDocumentsOfUnprovenPeersTakeNoRoomOfOrdinaryOnes) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto req = two.request();
  const auto rep = two.reply(*req->message);
  ASSERT_OK(rep);
  for (std::uint8_t i = 0; i < 30; ++i)
    ASSERT_OK(two.reply(large(*req->message, i, kMostPermissionsOctets)));
  pairing.expect_finish(*req, *rep);
}

struct UnprovenOctetsTest : testing::Test {
  /// Of a subject; the handshake has the next number.
  std::vector<HandshakeHandle> add(std::uint8_t subject, std::size_t count) {
    auto share = octets.take(Sha256Digest{subject}, count, 0);
    const HandshakeHandle owner{++last};
    share.belongs_to(owner);
    held.push_back(std::move(share));
    return octets.excess(random, owner);
  }
  static constexpr std::size_t kMany = 1024 * 1024;
  SeededRandom random{5};
  UnprovenOctets octets;
  std::vector<UnprovenOctets::Share> held;
  int last = 0;
};

TEST_F(UnprovenOctetsTest, ASubject_PaysForItself) {
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(add(1, kMany).empty());
  EXPECT_TRUE(add(2, kMany).empty());
  for (int i = 0; i < 20; ++i) {
    const auto dropped = add(1, kMany);
    ASSERT_EQ(dropped.size(), 1u);
    EXPECT_NE(dropped.front().value, 9) << "another subject's";
  }
}

TEST_F(UnprovenOctetsTest, ManySubjects_StayBelowTheTotal) {
  std::size_t dropped = 0;
  for (std::uint8_t i = 0; i < 40; ++i) dropped += add(i, kMany).size();
  EXPECT_EQ(dropped, 24u);
}

TEST_F(UnprovenOctetsTest, WhatIsGivenBack_MakesRoom) {
  for (int i = 0; i < 8; ++i) add(1, kMany);
  held.pop_back();
  EXPECT_TRUE(add(1, kMany).empty());
  EXPECT_EQ(add(1, kMany).size(), 1u);
}

TEST_F(UnprovenOctetsTest, AFewOctetsOfAPeer_AreFree) {
  const auto free = octets.take(Sha256Digest{1}, UnprovenOctets::kFreeOfAPeer, 0);
  EXPECT_EQ(free.free_octets(), UnprovenOctets::kFreeOfAPeer);
  const auto counted = octets.take(Sha256Digest{1}, 1, free.free_octets());
  EXPECT_EQ(counted.free_octets(), 0u);
}

// What it takes to meet a certain handshake is about the limit, whatever the size of the requests.
TEST_F(UnprovenOctetsTest, OneAmongMany_IsDroppedOnlyAfterAboutAsMuchAsTheLimit) {
  for (const std::size_t size : {std::size_t{66'000}, std::size_t{300'000}, kMany}) {
    std::size_t sent = 0;
    constexpr int kTurns = 40;
    for (int turn = 0; turn < kTurns; ++turn) {
      for (std::size_t filled = 0; filled < UnprovenOctets::kMostOfASubject; filled += size)
        add(1, size);
      add(1, kMany);
      const HandshakeHandle owner{last};
      for (bool is_there = true; is_there; sent += size)
        is_there = std::ranges::count(add(1, size), owner) == 0;
      held.clear();
    }
    EXPECT_GT(sent / kTurns, UnprovenOctets::kMostOfASubject / 2) << size;
  }
}

TEST(Bounds, FinishedHandshakesOfAPairAreFew) {
  Pairing pairing;
  std::vector<HandshakeHandle> handles;
  for (int i = 0; i < 10; ++i) {
    const auto req = pairing.two.request();
    const auto rep = pairing.two.reply(*req->message);
    ASSERT_OK(rep);
    pairing.expect_finish(*req, *rep);
    handles.push_back(req->handle);
  }
  std::size_t known = 0;
  for (const auto handle : handles)
    known += (*pairing.two.low.engine)->shared_secret(handle).has_value();
  EXPECT_LE(known, 5u);
  EXPECT_TRUE((*pairing.two.low.engine)->shared_secret(handles.back()));
}

}  // namespace
}  // namespace ddssec::authentication
