// Participants that limit for how long and for how much their keys are used. Keys that an attacker
// has learned are useful only until then, and no participant loses a sample by it.
#include <random>

#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

spi::PropertyList lifetime(int seconds) {
  return {{std::string(spi::property::kKeyLifetime), std::to_string(seconds), false}};
}
spi::PropertyList most_blocks(int blocks) {
  return {{std::string(spi::property::kMaxBlocksPerKey), std::to_string(blocks), false}};
}

// The plugins' clocks advance with the world's.
void live(World& world, milliseconds time) {
  for (milliseconds gone{0}; gone < time; gone += 10ms) {
    for (auto* node : world.nodes) node->clock.advance(10ms);
    world.run(1);
  }
}

void expect_in_order(const Listener& reader, std::size_t written) {
  ASSERT_EQ(reader.changes.size(), written);
  for (std::size_t i = 0; i < written; ++i)
    EXPECT_EQ(reader.changes[i].sequence_number.value, static_cast<std::int64_t>(i) + 1);
}

// No participant has lost trust. But keys that leaked, from carol or in another way, are useless
// afterwards.
TEST(KeyLimits, TimeLimit_EndsWhatALeakedKeyReads) {
  for (const auto& rules : {everything(kEncryptOa), Rules{.data = kEncrypt}}) {
    Trio trio(revising(rules), Short::nothing, lifetime(60));
    ASSERT_TRUE(trio.match()) << trio.text();
    Recorder leaked(trio.stolen);
    record(trio, leaked);
    traffic(trio);
    ASSERT_GT(leaked.seen(), 0);
    EXPECT_EQ(leaked.opened(), leaked.seen());
    for (auto* node : {&trio.a, &trio.b}) node->clock.advance(50s);
    ASSERT_TRUE(trio.revised(1)) << trio.text();
    trio.world.run(20);
    leaked.forget();
    traffic(trio);
    EXPECT_GT(leaked.seen(), 0);
    EXPECT_EQ(leaked.opened(), 0);
    EXPECT_TRUE(trio.bob_has_all()) << trio.text();
    EXPECT_EQ(trio.c.listener.changes.size(), trio.written) << "she is trusted";
    EXPECT_FALSE(trio.c.events.has(Code::rtps_keys_revised)) << "nothing limits hers";
  }
}

TEST(KeyLimits, BlockLimit_IsForTheSender) {
  Trio trio(revising({.data = kEncrypt}), Short::nothing, most_blocks(4000));
  ASSERT_TRUE(trio.match()) << trio.text();
  Recorder leaked(trio.stolen);
  record(trio, leaked);
  live(trio.world, 11s);
  for (int i = 0; i < 40; ++i) trio.write();
  live(trio.world, 2s);
  EXPECT_FALSE(trio.a.events.has(Code::rtps_keys_revised)) << "of the 4000 only some 240 are used";
  for (int i = 0; i < 5; ++i) trio.write(16'000);
  live(trio.world, 2s);
  EXPECT_EQ(trio.a.events.count(Code::rtps_keys_revised), 1);
  EXPECT_FALSE(trio.b.events.has(Code::rtps_keys_revised)) << "it sends little";
  leaked.forget();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  EXPECT_EQ(leaked.payloads, (Recorder::Level{.seen = 2, .opened = 0})) << "to bob and to carol";
}

// These use the lowest possible limits, with every fifth datagram lost, or none.
class ConstantRevision : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Network, ConstantRevision, ::testing::Values(false, true));

TEST_P(ConstantRevision, ReliableData_LosesNothing) {
  for (const auto& limit : {lifetime(20), most_blocks(1)}) {
    Trio trio(revising(everything(kEncryptOa)), Short::nothing, limit);
    ASSERT_TRUE(trio.match()) << trio.text();
    std::mt19937 random(7);
    if (GetParam())
      trio.world.filter = [&](const Node&, Bytes datagram) {
        return random() % 5 == 0 ? std::vector<Bytes>{} : one(std::move(datagram));
      };
    for (int i = 0; i < 500; ++i) {
      trio.write(i % 50 == 0 ? 20'000 : 64);
      live(trio.world, 100ms);
    }
    for (auto* node : {&trio.a, &trio.b}) {
      EXPECT_GE(node->events.count(Code::rtps_keys_revised), 4) << node->events.text();
      EXPECT_LE(node->events.count(Code::rtps_keys_revised), 13) << node->events.text();
    }
    EXPECT_TRUE(trio.bob_has_all()) << trio.text();
    trio.world.run(300);
    expect_in_order(trio.b.listener, trio.written);
    expect_in_order(trio.c.listener, trio.written);
    EXPECT_EQ(trio.a.listener.matched, 2) << "and nobody went";
  }
}

TEST(KeyLimits, ParticipantsThatStartTogether_EndApart) {
  constexpr int kMembers = 8;
  constexpr auto kLifetime = 80s;
  World world;
  std::vector<std::unique_ptr<Node>> members;
  for (std::uint8_t n = 1; n <= kMembers; ++n) {
    const auto properties = member("member " + std::to_string(n), revising({.rtps = kEncrypt}));
    members.push_back(
        std::make_unique<Node>(n, Pair::both(properties, lifetime(kLifetime.count())), kMembers));
    world.nodes.push_back(members.back().get());
  }
  const auto revisions = [&] {
    std::vector<int> out;
    for (const auto& one : members) out.push_back(one->events.count(Code::rtps_keys_revised));
    return out;
  };
  std::vector<seconds> first;
  int max_at_once = 0;
  for (seconds now{1}; now <= kLifetime; ++now) {
    const auto before = revisions();
    live(world, 1s);
    const auto after = revisions();
    int at_once = 0;
    for (int i = 0; i < kMembers; ++i) {
      const auto n = static_cast<std::size_t>(i);
      at_once += after[n] - before[n];
      if (before[n] == 0 && after[n] > 0) first.push_back(now);
    }
    max_at_once = std::max(max_at_once, at_once);
  }
  ASSERT_EQ(first.size(), static_cast<std::size_t>(kMembers)) << "each in time";
  EXPECT_GE(first.front(), kLifetime * 3 / 4 - 11s);
  EXPECT_LE(first.back(), kLifetime - 10s);
  EXPECT_GE(first.back() - first.front(), 10s) << "spread over a quarter of the time";
  EXPECT_LE(max_at_once, 3);
  for (const auto& one : members)
    EXPECT_FALSE(one->events.has(Code::rtps_key_revision_unacknowledged)) << one->events.text();
}

// The lifetime of a key begins with each revision, whatever the reason for it.
TEST(KeyLimits, EndOfTrust_StartsThemAnew) {
  Trio trio(revising(everything(kEncrypt)), Short::nothing, lifetime(100));
  ASSERT_TRUE(trio.match()) << trio.text();
  live(trio.world, 50s);
  trio.ignore(trio.c);
  live(trio.world, 50s);
  EXPECT_EQ(trio.a.events.count(Code::rtps_keys_revised), 1) << trio.text();
  live(trio.world, 41s);
  EXPECT_EQ(trio.a.events.count(Code::rtps_keys_revised), 2) << trio.text();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
}

TEST(KeyLimits, LimitsThatCannotBeKept_MakeNoParticipant) {
  struct Row {
    Rules rules;
    spi::PropertyList more;
    Code code;
  };
  const Rules fixed = everything(kEncrypt);
  Node host(1, member("host", fixed));
  for (const auto& [rules, more, code] :
       {Row{fixed, lifetime(3600), Code::key_limits_without_revision},
        Row{fixed, most_blocks(1), Code::key_limits_without_revision},
        Row{revising(fixed), lifetime(19), Code::invalid_property},
        Row{revising(fixed), most_blocks(-1), Code::invalid_property}}) {
    const auto own =
        OwnSecurity::create({{*host.authentication, *host.access_control, *host.cryptography},
                             Pair::both(member("strict", rules), more)},
                            0, Node::candidate(2));
    ASSERT_FALSE(own);
    EXPECT_EQ(own.error().code(), code);
  }
}

}  // namespace
}  // namespace ddssec::rtps
