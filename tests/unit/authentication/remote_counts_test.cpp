// The limits for remote identities, in total and for one certificate.
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(RemoteIdentityBounds, TooManyRemoteIdentities_AreRefused) {
  TestPlugin plugin(1, {.max_remote_identities = 3});
  Participant us(plugin, make_identity(test_ca(), "CN=ours"), 1);
  const Token token{"DDS:Auth:PKI-DH:1.0"};
  for (std::uint8_t i = 0; i < 3; ++i)
    ASSERT_OK(plugin->validate_remote_identity(us.handle, {}, token, candidate(0x80 + i)));
  EXPECT_CODE(plugin->validate_remote_identity(us.handle, {}, token, candidate(0x90)),
              too_many_remote_identities);
  // Identities that are known already are not affected. One that leaves makes room.
  const auto known = plugin->validate_remote_identity(us.handle, {}, token, candidate(0x80));
  ASSERT_OK(known);
  ASSERT_OK(plugin->return_identity_handle(known->handle));
  EXPECT_TRUE(plugin->validate_remote_identity(us.handle, {}, token, candidate(0x90)));
}

// A process whose participants share one certificate.
struct Fleet {
  explicit Fleet(const std::string& subject, std::uint64_t seed)
      : plugin(seed), identity(make_identity(test_ca(), subject, {}, kYear, 1)) {}
  // One more participant authenticates with `us`. Returns the error of the call in which `us`
  // refuses it.
  Result<IdentityHandle> join(Participant& us) {
    members.push_back(std::make_unique<Participant>(plugin, identity,
                                                    static_cast<std::uint8_t>(members.size() + 1)));
    auto& member = *members.back();
    if (auto known = us.discover(member); !known) return std::unexpected(known.error());
    Two two(us, member);
    const bool we_begin = &two.low == &us;
    const auto request = two.request();
    const auto reply = two.reply(*request->message);
    const auto final = two.process_at_lower_guid(request->handle, *reply->message);
    if (!final) return std::unexpected(final.error());
    if (const auto end = two.process_at_higher_guid(reply->handle, *final->message); !end)
      return std::unexpected(end.error());
    return we_begin ? two.high_at_low : two.low_at_high;
  }
  TestPlugin plugin;
  Identity identity;
  std::vector<std::unique_ptr<Participant>> members;
};

TEST(RemoteIdentityBounds, ACertificateThatFillsItsShare_LeavesRoomForAnother) {
  TestPlugin plugin(1, {.max_remote_identities = 8, .max_identities_of_a_subject = 3});
  Participant us(plugin, make_identity(test_ca(), "CN=ours"), 1);
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
  const auto& told = plugin.events.all.back().error;
  EXPECT_NE(told.to_sentence().find("CN=greedy"), std::string::npos);
  EXPECT_NE(told.to_sentence().find("at most 3 participants"), std::string::npos);
  EXPECT_TRUE(honest.join(us));
  // An identity that leaves makes room.
  ASSERT_OK(plugin->return_identity_handle(last));
  EXPECT_TRUE(greedy.join(us));
}

TEST(RemoteIdentityBounds, OneSubject_NeverTakesTheLastPlaces) {
  TestPlugin plugin(1, {.max_remote_identities = 8});
  Participant us(plugin, make_identity(test_ca(), "CN=ours"), 1);
  std::vector<int> joined;
  for (std::uint64_t number = 2; number < 8; ++number) {
    Fleet fleet("CN=fleet " + std::to_string(number), number);
    joined.push_back(0);
    while (fleet.join(us)) ++joined.back();
  }
  EXPECT_EQ(joined, (std::vector{4, 2, 1, 1, 0, 0}));
  EXPECT_CODE(us.discover(Participant(plugin, make_identity(test_ca(), "CN=one more"), 9)),
              too_many_remote_identities);
}

TEST(RemoteIdentityBounds, InventedParticipants_AreCountedApart) {
  TestPlugin plugin(1, {.max_remote_identities = 4, .max_identities_of_a_subject = 4});
  Participant us(plugin, make_identity(test_ca(), "CN=ours"), 1);
  Fleet fleet("CN=fleet", 2);
  std::vector<IdentityHandle> invented;
  const auto invent = [&](std::uint8_t number) -> Status {
    const auto known = plugin->validate_remote_identity(us.handle, {}, {"DDS:Auth:PKI-DH:1.0"},
                                                        candidate(0x80 + number));
    if (!known) return std::unexpected(known.error());
    invented.push_back(known->handle);
    return {};
  };
  for (std::uint8_t i = 0; i < 3; ++i) ASSERT_OK(invent(i));
  // The invented identities leave room for one claim at a time. A participant that proves its claim
  // frees it.
  EXPECT_TRUE(fleet.join(us));
  EXPECT_TRUE(fleet.join(us));
  ASSERT_OK(invent(3));
  const auto refused = fleet.join(us);
  EXPECT_CODE(refused, too_many_remote_identities);
  EXPECT_TRUE(spi::refusal_passes(refused.error().code()));
  ASSERT_OK(plugin->return_identity_handle(invented.back()));
  EXPECT_FALSE(fleet.join(us));  // it has two of four, and only as many are free
  EXPECT_TRUE(Fleet("CN=another", 3).join(us));
}

TEST(RemoteIdentityBounds, AShare_IsCheckedAgainWhenAClaimIsProven) {
  TestPlugin plugin(1, {.max_identities_of_a_subject = 1});
  Participant us(plugin, make_identity(test_ca(), "CN=ours"), 1);
  Fleet fleet("CN=fleet", 2);
  Participant first(fleet.plugin, fleet.identity, 1), second(fleet.plugin, fleet.identity, 2);
  Two with_first(us, first), with_second(us, second);
  const auto shake = [](Two& two) -> Status {
    const auto request = two.request();
    const auto reply = two.reply(*request->message);
    const auto final = two.process_at_lower_guid(request->handle, *reply->message);
    if (!final) return std::unexpected(final.error());
    const auto end = two.process_at_higher_guid(reply->handle, *final->message);
    return end ? Status() : std::unexpected(end.error());
  };
  ASSERT_OK(shake(with_first));
  EXPECT_CODE(shake(with_second), too_many_identities_of_subject);
  // An identity that is counted may authenticate again. When it leaves, it is not counted any more.
  EXPECT_TRUE(shake(with_first));
  const bool we_begin = &with_first.low == &us;
  ASSERT_OK(
      plugin->return_identity_handle(we_begin ? with_first.high_at_low : with_first.low_at_high));
  EXPECT_TRUE(shake(with_second));
}

}  // namespace
}  // namespace ddssec::authentication
