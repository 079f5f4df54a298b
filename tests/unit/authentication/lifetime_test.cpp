// Ends of validity, returned handles and bounds.
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
  EXPECT_EQ(event.error.details().expected, "2026-11-21T00:00:10Z");
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
