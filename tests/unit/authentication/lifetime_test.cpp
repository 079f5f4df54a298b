// Ends of validity.
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

struct Ending {
  explicit Ending(pki::Validity of_bob = {kNow - 24h, kNow + 10s})
      : pairing(make_identity(test_ca(), "CN=alice,O=Example"),
                make_identity(test_ca(), "CN=bob,O=Example", {}, of_bob, 1)) {}
  void advance(std::chrono::seconds by) {
    pairing.first_plugin.clock.advance(by);
    pairing.second_plugin.clock.advance(by);
  }
  IdentityHandle bob_at_alice() const {
    return &pairing.two.low == &pairing.a ? pairing.two.high_at_low : pairing.two.low_at_high;
  }
  IdentityHandle alice_at_bob() const {
    return &pairing.two.low == &pairing.a ? pairing.two.low_at_high : pairing.two.high_at_low;
  }
  Pairing pairing;
};

TEST(IdentityExpiry, EndedIdentities_AreRevokedOnce) {
  Ending ending;
  auto& pairing = ending.pairing;
  EXPECT_EQ(pairing.first_plugin->next_expiry(), kYear.not_after);
  pairing.expect_success();
  EXPECT_EQ(pairing.first_plugin->next_expiry(), kNow + 10s);
  EXPECT_EQ(pairing.second_plugin->next_expiry(), kNow + 10s);
  ending.advance(9s);
  EXPECT_TRUE(pairing.first_plugin->poll().empty());
  EXPECT_TRUE(pairing.second_plugin->poll().empty());
  ending.advance(1s);
  EXPECT_EQ(pairing.first_plugin->poll(), std::vector{ending.bob_at_alice()});
  EXPECT_EQ(pairing.second_plugin->poll(), (std::vector{pairing.b.handle, ending.alice_at_bob()}));
  EXPECT_TRUE(pairing.first_plugin->poll().empty());
  EXPECT_TRUE(pairing.second_plugin->poll().empty());
  EXPECT_EQ(pairing.first_plugin->next_expiry(), kYear.not_after);

  ASSERT_EQ(pairing.first_plugin.events.all.size(), 1u);
  const auto& event = pairing.first_plugin.events.all[0];
  EXPECT_EQ(event.error.code(), Code::identity_ended);
  EXPECT_EQ(event.peer_subject, "CN=bob,O=Example");
  EXPECT_EQ(event.guid, pairing.b.guid.to_string());
  EXPECT_EQ(event.error.details().expected, "a time before 2026-11-21T00:00:10Z");
  EXPECT_EQ(event.error.details().document, "CN=bob,O=Example");
}

TEST(IdentityExpiry, AnEndedIdentity_IsRefusedEverywhere) {
  Ending ending;
  auto& pairing = ending.pairing;
  pairing.expect_success();
  ending.advance(10s);
  pairing.first_plugin->poll();
  pairing.second_plugin->poll();
  EXPECT_CODE(pairing.a.discover(pairing.b), identity_ended);
  EXPECT_CODE(pairing.b.discover(pairing.a), identity_ended);
  EXPECT_CODE(pairing.two.request(), identity_ended);
  EXPECT_CODE(pairing.second_plugin->identity_token(pairing.b.handle), identity_ended);
  // Setting the clock back does not bring the identity back, because the host has cut it off.
  pairing.first_plugin.clock.set(kNow);
  EXPECT_CODE(pairing.a.discover(pairing.b), identity_ended);
  ASSERT_OK(pairing.first_plugin->return_identity_handle(ending.bob_at_alice()));
  EXPECT_TRUE(pairing.a.discover(pairing.b));
}

// T4 (docs/attacks.md): the calendar jumps, and the next look at it counts.
TEST(IdentityExpiry, CalendarThatIsSet_IsFollowed) {
  Ending ending({kNow - 24h, kNow + 1000h});
  auto& pairing = ending.pairing;
  pairing.expect_success();
  pairing.first_plugin.clock.set(kNow - 12h);
  EXPECT_TRUE(pairing.first_plugin->poll().empty());
  pairing.first_plugin.clock.set(kNow + 1001h);
  EXPECT_EQ(pairing.first_plugin->poll(), std::vector{ending.bob_at_alice()});
}

TEST(IdentityExpiry, EveryStep_JudgesAgain) {
  for (int step = 0; step < 4; ++step) {
    Ending ending;
    auto& pairing = ending.pairing;
    auto& two = pairing.two;
    const auto tick = [&](int at) {
      if (at == step) ending.advance(10s);
    };
    tick(0);
    const auto request = two.request();
    tick(1);
    const auto reply =
        request ? two.reply(*request->message) : Two::Step(std::unexpected(request.error()));
    tick(2);
    const auto final_message = reply ? two.process_at_lower_guid(request->handle, *reply->message)
                                     : Two::Step(std::unexpected(reply.error()));
    tick(3);
    const auto end = final_message
                         ? two.process_at_higher_guid(reply->handle, *final_message->message)
                         : Two::Step(std::unexpected(final_message.error()));
    EXPECT_CODE(end, certificate_expired);
  }
}

TEST(IdentityExpiry, EndOfTheCa_Counts) {
  const auto ca = make_ca("CN=Short CA", {}, {kNow - 24h, kNow + 5s});
  TestPlugin plugin;
  Participant alice(plugin, make_identity(ca, "CN=alice"), 1);
  EXPECT_EQ(plugin->next_expiry(), kNow + 5s);
  plugin.clock.advance(5s);
  EXPECT_EQ(plugin->poll(), std::vector{alice.handle});
  EXPECT_EQ(plugin.events.all.at(0).error.details().document, "CN=Short CA");
}

}  // namespace
}  // namespace ddssec::authentication
