// A peer that was not heard for longer than its lease comes back with its session.
#include "rtps/participant/resting_participants.hpp"

#include "tests/unit/rtps_security/deaf_pair.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct RestingParticipant : ::testing::TestWithParam<Rules> {};

TEST_P(RestingParticipant, HeardAgain_TakesPartAgain) {
  DeafPair deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  ASSERT_TRUE(deaf.lose_it());
  EXPECT_EQ(deaf.a.listener.matched, 0);
  EXPECT_TRUE(deaf.is_dormant());
  deaf.world.run(3000);
  deaf.is_unheard = false;
  EXPECT_TRUE(deaf.world.run_until([&] { return deaf.are_matched(); }, 1000));
  EXPECT_TRUE(deaf.samples_flow());
  EXPECT_FALSE(deaf.is_dormant());
  EXPECT_EQ(deaf.a->authentication_counters().authenticated, 1u) << "the session is the same";
  deaf.world.run(6000);
  EXPECT_TRUE(deaf.are_matched()) << "it answers";
}

TEST_P(RestingParticipant, WhatBothSidesChangedMeanwhile_IsKnownAfterwards) {
  DeafPair deaf(GetParam());
  ASSERT_TRUE(deaf.meet());
  const auto reader = deaf.create(deaf.b, false, "Star");
  ASSERT_TRUE(deaf.lose_it());
  const auto own = deaf.a->create_writer({"Star", "ShapeType", default_writer_qos(), true},
                                         deaf.a.listener, deaf.world.now);
  ASSERT_TRUE(own);
  deaf.a->remove(deaf.writers[0], deaf.world.now);
  deaf.create(deaf.b, true, "Triangle");
  deaf.create(deaf.a, false, "Triangle");
  deaf.world.run(500);
  deaf.is_unheard = false;
  EXPECT_TRUE(deaf.world.run_until(
      [&] {
        const auto& known = deaf.a.listener.known;
        return deaf.are_matched(3) && known.contains(reader) && known.contains(deaf.writers[1]) &&
               !deaf.b.listener.known.contains(deaf.writers[0]);
      },
      3000));
}

TEST_P(RestingParticipant, UnheardWhileKeysAreExchanged_Joins) {
  DeafPair deaf(GetParam());
  deaf.loses_keys = true;
  const auto awaits = [&] {
    const auto* peer = core_of(deaf.a).find(deaf.b->prefix());
    return peer != nullptr && peer->state.awaiting_keys() != nullptr;
  };
  ASSERT_TRUE(deaf.world.run_until(awaits, 500));
  deaf.world.run(20);
  deaf.become_stock();
  ASSERT_TRUE(awaits());
  ASSERT_TRUE(deaf.lose_it());
  EXPECT_TRUE(deaf.is_dormant());
  deaf.is_unheard = deaf.loses_keys = false;
  EXPECT_TRUE(deaf.world.run_until([&] { return deaf.a.knows(deaf.b); }, 1000));
}

INSTANTIATE_TEST_SUITE_P(Protected, RestingParticipant,
                         ::testing::ValuesIn(rules_for_deaf_pairs()));

}  // namespace
}  // namespace ddssec::rtps
