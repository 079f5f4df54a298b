// Two local identities in one plugin that deal with the same remote one: what happens to one of
// them does not affect the other. (With threads: tests/attack/authentication/threads_test.cpp.)
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

// A remote participant in a plugin of its own, and `first` and `second` in one plugin.
struct TwoLocals {
  explicit TwoLocals(pki::Validity of_first = kYear, pki::Validity of_remote = kYear,
                     AuthenticationOptions options = {})
      : ours(1, options),
        first(ours, make_identity(test_ca(), "CN=first,O=Example", {}, of_first), 1),
        second(ours, make_identity(test_ca(), "CN=second,O=Example", {}, kYear, 1), 2),
        remote(theirs, make_identity(test_ca(), "CN=remote,O=Example", {}, of_remote, 2), 3),
        of_first(first, remote),
        of_second(second, remote) {}

  void advance(std::chrono::seconds by) {
    ours.clock.advance(by);
    theirs.clock.advance(by);
  }
  // Returns the handle of the remote at the local participant of `two`.
  IdentityHandle remote_of(const Two& two) const {
    return &two.low == &remote ? two.low_at_high : two.high_at_low;
  }
  IdentityHandle remote_of_first() const { return remote_of(of_first); }
  IdentityHandle remote_of_second() const { return remote_of(of_second); }

  TestPlugin ours;
  TestPlugin theirs{2};
  Participant first, second, remote;
  Two of_first, of_second;
};

// A handshake of which the test takes each step.
class Handshake {
 public:
  explicit Handshake(Two& two) : two_(two) {}
  void request() { ASSERT_TRUE(ok(request_ = two_.request())); }
  void reply() { ASSERT_TRUE(ok(reply_ = two_.reply(*(*request_)->message))); }
  void final() {
    ASSERT_TRUE(ok(final_ = two_.process_at_lower_guid((*request_)->handle, *(*reply_)->message)));
    ASSERT_TRUE(ok(end_ = two_.process_at_higher_guid((*reply_)->handle, *(*final_)->message)));
  }
  void all() {
    request();
    reply();
    final();
  }
  std::shared_ptr<const spi::SharedSecret> of_low() const {
    return (*two_.low.plugin)->shared_secret((*request_)->handle).value_or(nullptr);
  }
  std::shared_ptr<const spi::SharedSecret> of_high() const {
    return (*two_.high.plugin)->shared_secret((*reply_)->handle).value_or(nullptr);
  }
  void expect_one_secret() const {
    const auto low = of_low();
    const auto high = of_high();
    ASSERT_TRUE(low && high);
    EXPECT_EQ(low->secret, high->secret);
  }

 private:
  static bool ok(const std::optional<Two::Step>& step) {
    if (!*step) ADD_FAILURE() << step->error().to_sentence();
    return step->has_value();
  }
  Two& two_;
  std::optional<Two::Step> request_, reply_, final_, end_;
};

TEST(TwoLocals, SameRemote_HasAHandleForEach) {
  TwoLocals world;
  EXPECT_NE(world.remote_of_first(), world.remote_of_second());
  const auto again = world.first.discover(world.remote);
  ASSERT_OK(again);
  EXPECT_EQ(again->handle, world.remote_of_first());
}

TEST(TwoLocals, HandleOfTheOther_IsRefused) {
  TwoLocals world;
  auto& plugin = world.ours;
  EXPECT_CODE(plugin->begin_handshake_request(world.second.handle, world.remote_of_first(),
                                              world.second.data),
              unknown_identity);
  EXPECT_CODE(plugin->begin_handshake_reply({}, world.remote_of_second(), world.first.handle,
                                            world.first.data),
              unknown_identity);
}

TEST(TwoLocals, InterleavedHandshakes_EndInASecretEach) {
  TwoLocals world;
  Handshake first(world.of_first), second(world.of_second);
  first.request();
  second.request();
  second.reply();
  first.reply();
  first.final();
  second.final();
  first.expect_one_secret();
  second.expect_one_secret();
  EXPECT_NE(first.of_low()->secret, second.of_low()->secret);
}

TEST(TwoLocals, ASecondHandshakeOfTheOne_LeavesTheOthersSecret) {
  TwoLocals world;
  Handshake first(world.of_first), second(world.of_second), again(world.of_second);
  first.all();
  second.all();
  const auto secret = first.of_low();
  again.all();
  EXPECT_EQ(first.of_low(), secret);
  EXPECT_NE(again.of_low()->secret, second.of_low()->secret);
}

TEST(TwoLocals, ReturningTheRemoteOfOne_LeavesItToTheOther) {
  for (const bool second_goes : {false, true}) {
    TwoLocals world;
    auto& goes = second_goes ? world.of_second : world.of_first;
    auto& stays = second_goes ? world.of_first : world.of_second;
    Handshake finished(stays), of_gone(goes), under_way(stays);
    finished.all();
    of_gone.all();
    under_way.request();
    under_way.reply();
    ASSERT_OK(world.ours->return_identity_handle(world.remote_of(goes)));
    EXPECT_CODE(world.ours->return_identity_handle(world.remote_of(goes)), unknown_identity);
    EXPECT_FALSE(of_gone.of_low() && of_gone.of_high());
    finished.expect_one_secret();
    under_way.final();
    under_way.expect_one_secret();
    // The remote may come again, as a new identity.
    Two anew(second_goes ? world.second : world.first, world.remote);
    EXPECT_NE(world.remote_of(anew), world.remote_of(goes));
    Handshake(anew).all();
    ASSERT_OK(world.ours->return_identity_handle(world.remote_of(stays)));
    EXPECT_FALSE(finished.of_low() && finished.of_high());
  }
}

TEST(TwoLocals, ReturningOneOfThem_TakesItsRemotesOnly) {
  TwoLocals world;
  Handshake first(world.of_first), second(world.of_second);
  first.all();
  second.request();
  ASSERT_OK(world.ours->return_identity_handle(world.first.handle));
  EXPECT_CODE(world.ours->return_identity_handle(world.remote_of_first()), unknown_identity);
  EXPECT_FALSE(first.of_low() && first.of_high());
  second.reply();
  second.final();
  second.expect_one_secret();
}

TEST(TwoLocals, AnotherToken_IsAdmittedForBoth) {
  TwoLocals world;
  Handshake(world.of_first).all();
  const Token other{"DDS:Auth:PKI-DH:1.0"};
  EXPECT_TRUE(
      world.ours->validate_remote_identity(world.first.handle, {}, other, world.remote.guid));
  EXPECT_TRUE(
      world.ours->validate_remote_identity(world.second.handle, {}, other, world.remote.guid));
}

TEST(TwoLocals, WhatOneDistrusts_TheOtherMayTrust) {
  const auto strict_ca = make_ca("CN=Another CA");
  TwoLocals world;
  Participant strict(world.ours, make_identity(strict_ca, "CN=strict,O=Example"), 4);
  Two distrusting(strict, world.remote);
  // The remote does not trust the other one either, so the test plays its part up to the message
  // that the strict one refuses.
  const auto request = distrusting.request();
  ASSERT_OK(request);
  EXPECT_FALSE(distrusting.reply(*request->message));
  Handshake first(world.of_first);
  first.all();
  first.expect_one_secret();
}

// Each host asks for its own ends, and gets no end that another host must hear of.
TEST(TwoLocals, TheEndOfTheRemote_IsToldToEach) {
  TwoLocals world(kYear, {kNow - 24h, kNow + 10s});
  Handshake(world.of_first).all();
  Handshake(world.of_second).all();
  world.advance(10s);
  EXPECT_EQ(world.ours->poll(world.first.handle), std::vector{world.remote_of_first()});
  EXPECT_TRUE(world.ours->poll(world.first.handle).empty());
  EXPECT_EQ(world.ours->poll(world.second.handle), std::vector{world.remote_of_second()});
  EXPECT_TRUE(world.ours->poll().empty());
}

TEST(TwoLocals, HostThatAsksForAll_IsToldOfAll) {
  TwoLocals world(kYear, {kNow - 24h, kNow + 10s});
  Handshake(world.of_first).all();
  Handshake(world.of_second).all();
  world.advance(10s);
  EXPECT_EQ(world.ours->poll(), (std::vector{world.remote_of_first(), world.remote_of_second()}));
  EXPECT_TRUE(world.ours->poll(world.second.handle).empty());
}

TEST(TwoLocals, EndOfOne_LeavesTheOthersRemote) {
  TwoLocals world({kNow - 24h, kNow + 10s});
  Handshake(world.of_first).all();
  Handshake second(world.of_second), again(world.of_second);
  second.all();
  world.advance(10s);
  EXPECT_TRUE(world.ours->poll(world.second.handle).empty());
  EXPECT_EQ(world.ours->poll(world.first.handle),
            (std::vector{world.first.handle, world.remote_of_first()}));
  EXPECT_TRUE(world.ours->poll().empty());
  second.expect_one_secret();
  EXPECT_TRUE(world.second.discover(world.remote));
  again.all();
}

TEST(TwoLocals, CrowdOfStrangersAtTheOne_LeavesTheOtherItsRoom) {
  TwoLocals world(kYear, kYear, {.max_remote_identities = 2});
  const auto discover = [&](const Participant& by, std::uint8_t number) {
    return world.ours->validate_remote_identity(by.handle, {}, {"DDS:Auth:PKI-DH:1.0"},
                                                candidate(number));
  };
  ASSERT_OK(discover(world.first, 0x80));
  EXPECT_CODE(discover(world.first, 0x81), too_many_remote_identities);
  EXPECT_TRUE(discover(world.second, 0x81));
}

}  // namespace
}  // namespace ddssec::authentication
