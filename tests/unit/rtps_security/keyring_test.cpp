// When the keys of a participant are waited for.
#include "rtps/security/keyring.hpp"

#include "tests/unit/rtps_security/key_thief.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Sends no keys of its participant, as OpenDDS does if messages are not protected.
class WithoutParticipantKeys final : public KeyThief {
 public:
  using KeyThief::KeyThief;

 private:
  Result<Tokens> create_local_participant_crypto_tokens(Participant, Participant,
                                                        spi::KeyStage) override {
    return Tokens{};
  }
};

TEST(Joining, ParticipantKeys_AreWaitedForOnlyWhereTheyAreNeeded) {
  for (const auto& rules : {Rules{}, Rules{.data = kEncrypt}, Rules{.metadata = kEncrypt},
                            Rules{.discovery = kEncrypt}, Rules{.rtps = kEncrypt}}) {
    KeyThief::Stolen unused;
    Node a(1, properties_of("CN=alice,O=Example", rules));
    Node b(2, properties_of("CN=bob,O=Example", rules), 3, [&](auto plugin) {
      return std::make_unique<WithoutParticipantKeys>(std::move(plugin), unused);
    });
    World world{{&a, &b}};
    ASSERT_TRUE(a->create_writer(square(default_writer_qos()), a.listener, world.now));
    ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
    const bool needed = is_protected(rules.rtps);
    const bool matched = world.run_until(
        [&] { return a.listener.matched == 1 && b.listener.matched == 1; }, needed ? 500 : 1000);
    EXPECT_EQ(matched, !needed) << a.events.text();
    EXPECT_EQ(a.knows(b), !needed);
    EXPECT_EQ(a->authentication_counters().authenticated, needed ? 0u : 1u);
  }
}

}  // namespace
}  // namespace ddssec::rtps
