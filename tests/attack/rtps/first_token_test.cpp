// A stranger is the first to announce a participant, with another identity token. The token must
// not keep the participant out when it comes back.
#include "tests/attack/rtps/announced_by.hpp"
#include "tests/unit/rtps_security/deaf_pair.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Bob's identity token as a stranger writes it: one property differs, or there is one more.
Bytes with_another_token(ParticipantData data) {
  data.identity_token->properties.push_back({"dds.cert.sn2", "x", true});
  return announcement(data);
}

// Lets nothing arrive until both have lost each other. Returns false if they have not.
bool part(Pair& pair) {
  pair.world.filter = [](const Node&, Bytes) { return std::vector<Bytes>{}; };
  const auto is_alone = [](Node& node) { return node->remote_participants().size() == 0; };
  const bool are_alone =
      pair.world.run_until([&] { return is_alone(pair.a) && is_alone(pair.b); }, 6000);
  pair.world.filter = {};
  return are_alone;
}

struct FirstToken : ::testing::TestWithParam<std::tuple<bool, bool>> {};

// Key revision keeps the identity of a peer that left. The stranger's token is kept with it.
TEST_P(FirstToken, StrangersToken_DoesNotKeepAPeerOutThatComesBack) {
  const auto [is_forged, is_of_lower] = GetParam();
  Pair pair(revising(everything(kEncrypt)));
  auto& world = pair.world;
  auto& deceived = is_of_lower ? pair.b : pair.a;
  auto& other = is_of_lower ? pair.a : pair.b;
  const auto true_data = announced_by(world, other);
  if (is_forged)
    deceived->receive(with_another_token(true_data), world.now, *Locator::parse("127.0.0.9", 0));
  ASSERT_TRUE(pair.match());
  ASSERT_TRUE(part(pair));
  EXPECT_TRUE(world.run_until([&] { return know_each_other(pair); }, 60'000))
      << pair.a.events.text() << "--\n"
      << pair.b.events.text();
}

INSTANTIATE_TEST_SUITE_P(All, FirstToken, ::testing::Combine(::testing::Bool(), ::testing::Bool()));

// A peer of another product is dormant here while it begins a new session.
struct FirstTokenOfStock : ::testing::TestWithParam<bool> {};

TEST_P(FirstTokenOfStock, StrangersToken_DoesNotKeepAPeerOutThatBeginsAgain) {
  Pair pair(everything(kEncrypt));
  auto& world = pair.world;
  const auto true_data = announced_by(world, pair.b);
  if (GetParam())
    pair.a->receive(with_another_token(true_data), world.now, *Locator::parse("127.0.0.9", 0));
  ASSERT_TRUE(pair.match());
  treat_as_stock(pair.a, pair.b);
  ASSERT_TRUE(part(pair));
  ASSERT_TRUE(core_of(pair.a).dormant.contains(pair.b->prefix()));
  EXPECT_TRUE(world.run_until([&] { return know_each_other(pair); }, 60'000))
      << pair.a.events.text() << "--\n"
      << pair.b.events.text();
}

INSTANTIATE_TEST_SUITE_P(All, FirstTokenOfStock, ::testing::Bool());

}  // namespace
}  // namespace ddssec::rtps
