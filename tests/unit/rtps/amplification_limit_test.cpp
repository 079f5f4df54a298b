#include "rtps/budget/amplification_limit.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

Locator at(std::uint8_t host, std::uint16_t port = 7410) {
  return Locator::udp_v4({192, 0, 2, host}, port);
}

class AmplificationLimitTest : public ::testing::Test {
 protected:
  // Begins a limit for these addresses, announced by that host.
  void announce(std::uint8_t host, const LocatorList& addresses, std::size_t octets) {
    const std::vector sources(addresses.size(), SourceAddress(at(host)));
    limit_.begin_datagram(SourceAddress(at(host)), octets);
    limit_.begin(name_, addresses, sources);
    limit_.add_credit(name_);
  }
  std::size_t hear(std::uint8_t host, std::size_t octets) {
    limit_.begin_datagram(SourceAddress(at(host)), octets);
    return limit_.add_credit(name_);
  }
  std::size_t sent(std::size_t octets, const LocatorList& to) {
    return octets * limit_.charge(name_, octets, to).size();
  }

  AmplificationLimitTest() { limit_.set_secret(sha256(as_bytes("secret"))); }
  // The participant sends back the challenge that it got at that host.
  bool prove(std::uint8_t host) { return limit_.prove(name_, limit_.challenge(name_, at(host))); }

  AmplificationLimit limit_;
  const GuidPrefix name_ = GuidPrefix::from(Bytes(12, 1));
};

TEST_F(AmplificationLimitTest, PeerThatWasNeverLimited_GetsEverything) {
  EXPECT_FALSE(limit_.is_limited(name_));
  EXPECT_EQ(sent(1'000'000, {at(1), at(2)}), 2'000'000u);
}

TEST_F(AmplificationLimitTest, AllAddressesTogether_GetLessThanThreeTimesTheOctets) {
  const LocatorList addresses{at(1), at(1, 7412), at(2), at(3)};
  announce(1, addresses, 400);
  std::size_t total = 0;
  for (int i = 0; i < 100; ++i) total += sent(100, addresses);
  EXPECT_EQ(total, 1100u);
  EXPECT_EQ(limit_.left(name_, addresses), 99u);
  EXPECT_EQ(sent(99, addresses), 99u);
  EXPECT_EQ(sent(1, addresses), 0u);
}

TEST_F(AmplificationLimitTest, AMessageThatDoesNotFit_IsNotChargedAndFitsAfterTheNextDatagram) {
  announce(1, {at(1)}, 400);
  EXPECT_EQ(sent(2000, {at(1)}), 0u);
  EXPECT_EQ(hear(1, 400), 1200u);
  EXPECT_EQ(sent(2000, {at(1)}), 2000u);
}

TEST_F(AmplificationLimitTest, ADatagram_CountsOnce) {
  announce(1, {at(1)}, 400);
  EXPECT_EQ(limit_.add_credit(name_), 0u);
  const auto other = GuidPrefix::from(Bytes(12, 2));
  limit_.begin(other, LocatorList{at(1)}, std::vector{SourceAddress(at(1))});
  EXPECT_EQ(limit_.add_credit(other), 0u);
}

TEST_F(AmplificationLimitTest, OneSource_DoesNotUseUpWhatAnotherEarned) {
  announce(1, {at(1)}, 400);
  const LocatorList both{at(1), at(9)};
  limit_.set_addresses(name_, both, std::vector{SourceAddress(at(1)), SourceAddress(at(66))});
  hear(66, 100);
  EXPECT_EQ(limit_.charge(name_, 299, both), both);
  EXPECT_EQ(limit_.charge(name_, 299, both), LocatorList{at(1)});
  EXPECT_EQ(limit_.left(name_, LocatorList{at(9)}), 0u);
}

TEST_F(AmplificationLimitTest, AddressOfNoParticipant_GetsNothing) {
  announce(1, {at(1)}, 400);
  EXPECT_EQ(sent(10, {at(7)}), 0u);
}

TEST_F(AmplificationLimitTest, AnotherSourceOfThePeer_EarnsForTheFirst) {
  announce(1, {at(1)}, 400);
  EXPECT_EQ(hear(5, 100), 300u);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(1)}), 1499u);
}

TEST_F(AmplificationLimitTest, AHostThatSends_PaysForItsAddressThatAnotherAnnouncedFirst) {
  announce(66, {at(9)}, 400);
  const LocatorList both{at(9), at(1)};
  limit_.set_addresses(name_, both, std::vector{SourceAddress(at(66)), SourceAddress(at(67))});
  EXPECT_EQ(hear(1, 400), 1200u);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(1)}), 1199u);
  EXPECT_EQ(hear(67, 500), 1500u);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(1)}), 1499u);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(9)}), 1199u);
}

TEST_F(AmplificationLimitTest, AHost_ProvesItsAddressThatAnotherAnnouncedFirst) {
  announce(66, {at(1), at(9)}, 400);
  EXPECT_TRUE(prove(1));
  EXPECT_EQ(limit_.charge(name_, 50'000, LocatorList{at(1), at(9)}), LocatorList{at(1)});
}

TEST_F(AmplificationLimitTest, AnotherSourceOfThePeer_PaysForEachAddressInTurn) {
  announce(66, {at(9)}, 400);
  sent(1199, {at(9)});
  const LocatorList both{at(9), at(1)};
  limit_.set_addresses(name_, both, std::vector{SourceAddress(at(66)), SourceAddress(at(67))});
  for (int i = 0; i < 4; ++i) hear(5, 100);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(1)}), 599u);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(9)}), 600u);
}

TEST_F(AmplificationLimitTest, AProvenAddress_IsFreeAndTheOthersAreNot) {
  announce(1, {at(1), at(2)}, 400);
  EXPECT_TRUE(prove(1));
  EXPECT_EQ(limit_.charge(name_, 50'000, LocatorList{at(1), at(2)}), LocatorList{at(1)});
  EXPECT_EQ(limit_.left(name_, LocatorList{at(2)}), 1199u);
}

// The attacker can be reached at one address. It also names an address of the victim, and sends
// datagrams with that address as their source.
TEST_F(AmplificationLimitTest, WhatWasSentToOneHost_ProvesNoOther) {
  announce(66, {at(66), at(1)}, 400);
  hear(1, 0);
  EXPECT_TRUE(prove(66));
  EXPECT_EQ(limit_.charge(name_, 50'000, LocatorList{at(66), at(1)}), LocatorList{at(66)});
}

TEST_F(AmplificationLimitTest, OneIpv6Address_ProvesNoOtherOfItsNetwork) {
  const auto own = *Locator::parse("fd77::1", 7410), other = *Locator::parse("fd77::3", 7410);
  limit_.begin(name_, LocatorList{own, other}, std::vector(2, SourceAddress(own)));
  EXPECT_TRUE(limit_.prove(name_, limit_.challenge(name_, own)));
  EXPECT_TRUE(limit_.is_proven(name_, own));
  EXPECT_FALSE(limit_.is_proven(name_, other));
}

TEST_F(AmplificationLimitTest, AHostThatWasNotAnnounced_ProvesNone) {
  announce(66, {at(1)}, 400);
  EXPECT_FALSE(prove(5));
  EXPECT_EQ(sent(50'000, {at(1)}), 0u);
}

TEST_F(AmplificationLimitTest, TheChallengeOfAnotherParticipantOrSecret_ProvesNothing) {
  announce(1, {at(1)}, 400);
  const auto host = at(1);
  EXPECT_FALSE(limit_.prove(name_, limit_.challenge(GuidPrefix::from(Bytes(12, 2)), host)));
  AmplificationLimit other;
  other.set_secret(sha256(as_bytes("another secret")));
  EXPECT_FALSE(limit_.prove(name_, other.challenge(name_, host)));
}

TEST_F(AmplificationLimitTest, LimitWithoutASecret_ProvesNothing) {
  AmplificationLimit limit;
  limit.begin(name_, LocatorList{at(1)}, std::vector{SourceAddress(at(1))});
  EXPECT_TRUE(limit.challenge(name_, at(1)).empty());
  EXPECT_FALSE(limit.prove(name_, {}));
}

TEST_F(AmplificationLimitTest, WhatIsSaved_IsBounded) {
  announce(1, {at(1)}, 400);
  for (int i = 0; i < 1000; ++i) hear(1, 60'000);
  EXPECT_EQ(limit_.left(name_, LocatorList{at(1)}), AmplificationLimit::kMaxSaved - 1);
}

TEST_F(AmplificationLimitTest, PeerThatIsLimitedAgain_BeginsWithNothing) {
  announce(1, {at(1)}, 400);
  limit_.end(name_);
  EXPECT_EQ(sent(50'000, {at(1)}), 50'000u);
  limit_.begin(name_, LocatorList{at(1)}, std::vector{SourceAddress(at(1))});
  EXPECT_EQ(sent(1, {at(1)}), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
