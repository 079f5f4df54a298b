// How much memory the requests of peers that have proven nothing may hold.
#include "plugins/authentication/unproven_octets.hpp"

#include <gmock/gmock.h>

#include "plugins/authentication/credentials.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

struct UnprovenOctetsTest : testing::Test {
  // Adds a request of that subject. Its handshake has the next number.
  std::vector<HandshakeHandle> add(std::uint8_t subject, std::size_t count) {
    auto share = octets.claim(Sha256Digest{subject}, count, 0);
    const HandshakeHandle owner{++last};
    share.assign_to(owner);
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
  const auto free = octets.claim(Sha256Digest{1}, UnprovenOctets::kFreeOfAPeer, 0);
  EXPECT_EQ(free.free_octets(), UnprovenOctets::kFreeOfAPeer);
  const auto counted = octets.claim(Sha256Digest{1}, 1, free.free_octets());
  EXPECT_EQ(counted.free_octets(), 0u);
}

// To have a certain handshake dropped, an attacker must send about as much as the limit, whatever
// the size of the requests.
TEST_F(UnprovenOctetsTest, OneAmongMany_IsDroppedOnlyAfterAboutAsMuchAsTheLimit) {
  for (const std::size_t size : {std::size_t{66'000}, std::size_t{300'000}, kMany}) {
    std::size_t sent = 0;
    constexpr int kTurns = 40;
    for (int turn = 0; turn < kTurns; ++turn) {
      for (std::size_t filled = 0; filled < UnprovenOctets::kMaxOfASubject; filled += size)
        add(1, size);
      add(1, kMany);
      const HandshakeHandle owner{last};
      for (bool is_there = true; is_there; sent += size)
        is_there = std::ranges::count(add(1, size), owner) == 0;
      held.clear();
    }
    EXPECT_GT(sent / kTurns, UnprovenOctets::kMaxOfASubject / 2) << size;
  }
}

// ---- in the plugin

// Returns the same request with permissions of that size, and without a signature.
Token large(const Token& request, std::uint8_t number, std::size_t octets) {
  return with(forged(request, number), "c.perm", Bytes(octets, 'x'));
}

// A stranger with a recorded request announces participants with its subject, and sends a request
// with junk in the name of each.
class Stranger {
 public:
  Stranger(const Token& recorded, const Identity& recorded_identity, Participant& victim)
      : recorded_(recorded), identity_(recorded_identity), victim_(victim) {}

  // Sends permissions of that many octets. Returns the reply of the victim.
  Two::Step sends(std::size_t octets) {
    const auto number = static_cast<std::uint8_t>(++sent_);
    Participant invented(plugin_, identity_, number + 10);
    Two two(invented, victim_);
    return two.reply(with(large(recorded_, number, octets), "c.pdata", invented.data));
  }

 private:
  const Token recorded_;
  const Identity identity_;
  Participant& victim_;
  TestPlugin plugin_{9};
  int sent_ = 0;
};

// The participant with the lower GUID has a document of that size, and a stranger knows its
// certificate.
struct LargeDocuments {
  explicit LargeDocuments(std::size_t octets)
      : alice(make_identity(test_ca(), "CN=alice,O=Example")),
        bob(make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1)),
        pairing(alice, bob) {
    Token credential{.class_id = std::string(spi::class_id::kPermissionsCredential)};
    credential.properties.push_back({"dds.perm.cert", std::string(octets, 'p'), false});
    EXPECT_TRUE(
        (*low().plugin)->set_permissions_credential_and_token(low().handle, credential, {}));
    request = pairing.two.request();
  }
  Participant& low() { return pairing.two.low; }
  Stranger stranger() {
    return {*(*request)->message, &low() == &pairing.a ? alice : bob, pairing.two.high};
  }
  std::vector<Event>& events() { return pairing.two.high.plugin->events.all; }

  Identity alice, bob;
  Pairing pairing;
  std::optional<Two::Step> request;
};

TEST(UnprovenOctetsBounds, OwnerOfLargeDocuments_GetsInWhileAStrangerFillsItsSubject) {
  for (const std::size_t size : {std::size_t{86'000}, kMaxPermissionsOctets}) {
    LargeDocuments world(size);
    auto stranger = world.stranger();
    for (int i = 0; i < 12; ++i) ASSERT_OK(stranger.sends(kMaxPermissionsOctets));
    const auto reply = world.pairing.two.reply(*(*world.request)->message);
    ASSERT_OK(reply);
    world.pairing.expect_finish(**world.request, *reply);
  }
}

// The handshake to drop is drawn at random each time, so it is not always the owner's.
TEST(UnprovenOctetsBounds, OwnerOfLargeDocuments_OutlivesSomeRequestsThatComeAfterIts) {
  int finished = 0;
  for (int turn = 0; turn < 8; ++turn) {
    LargeDocuments world(kMaxPermissionsOctets);
    auto stranger = world.stranger();
    for (int i = 0; i < 10 + turn; ++i) ASSERT_OK(stranger.sends(kMaxPermissionsOctets));
    const auto reply = world.pairing.two.reply(*(*world.request)->message);
    ASSERT_OK(reply);
    ASSERT_OK(stranger.sends(kMaxPermissionsOctets));
    const auto final =
        world.pairing.two.process_at_lower_guid((*world.request)->handle, *reply->message);
    ASSERT_OK(final);
    finished +=
        world.pairing.two.process_at_higher_guid(reply->handle, *final->message).has_value();
  }
  EXPECT_GE(finished, 4);
}

TEST(UnprovenOctetsBounds, DroppedRequestOfAStranger_IsAnEventWithTheLimits) {
  LargeDocuments world(86'000);
  auto stranger = world.stranger();
  for (int i = 0; i < 9; ++i) ASSERT_OK(stranger.sends(kMaxPermissionsOctets));
  ASSERT_FALSE(world.events().empty());
  EXPECT_EQ(world.events().back().error.code(), Code::too_many_handshakes);
  EXPECT_THAT(world.events().back().error.to_sentence(),
              testing::HasSubstr("8388608 octets of a subject"));
}

TEST(UnprovenOctetsBounds, LargeDocumentsOfUnprovenPeers_TakeNoRoomOfOrdinaryOnes) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  for (std::uint8_t i = 0; i < 30; ++i)
    ASSERT_OK(two.reply(large(*request->message, i, kMaxPermissionsOctets)));
  pairing.expect_finish(*request, *reply);
}

}  // namespace
}  // namespace ddssec::authentication
