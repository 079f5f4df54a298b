#include "plugins/cryptography/match_shares.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

TEST(MatchShares, OneSubject_HasItsShareAndNoMore) {
  MatchShares matches;
  for (std::size_t i = 0; i < MatchShares::kMaxOfSubject; ++i) ASSERT_TRUE(matches.claim(1));
  EXPECT_EQ(code_of(matches.claim(1)), Code::too_many_matches);
  EXPECT_TRUE(matches.claim(2)) << "another subject";
  std::optional<std::uint64_t> share = 1;
  matches.release(share);
  EXPECT_FALSE(share);
  matches.release(share);  // does nothing, because no match was counted
  EXPECT_TRUE(matches.claim(1));
  EXPECT_EQ(code_of(matches.claim(1)), Code::too_many_matches);
}

TwoSides trusting_host() {
  auto attributes = participant_attributes(ProtectionKind::encrypt);
  attributes.discovery = ProtectionKind::encrypt;
  return TwoSides(attributes, {}, CryptographyOptions{.host_checks_sources = false});
}

// Matches one local writer with readers of one peer until that fails, or `most` are matched.
std::size_t matched(TwoSides& two, const spi::EndpointSecurityAttributes& attributes,
                    std::size_t most) {
  auto& factory = two.b.factory();
  const auto writer = factory.register_local_datawriter(two.b.participant, {}, attributes).value();
  for (std::size_t count = 0; count < most; ++count)
    if (!factory.register_matched_remote_datareader(writer, two.b.remote, shared_secret(), false))
      return count;
  return most;
}

spi::EndpointSecurityAttributes announced_under_keys() {
  auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
  attributes.topic.is_discovery_protected = true;
  return attributes;
}

TEST(MatchShares, HostThatTrustsItsPeers_IsGivenNoMoreMatches) {
  constexpr auto kMost = MatchShares::kMaxOfSubject;
  auto two = trusting_host();
  EXPECT_EQ(matched(two, announced_under_keys(), 2 * kMost), kMost);
  EXPECT_EQ(two.b.events.codes(), std::vector{Code::too_many_matches});
  EXPECT_EQ(matched(two, announced_under_keys(), 3), 3u) << "each local endpoint has its own";
}

TEST(MatchShares, WhatNoKeyHasAnnounced_IsNotCounted) {
  constexpr auto kMost = MatchShares::kMaxOfSubject;
  auto two = trusting_host();
  auto attributes = announced_under_keys();
  attributes.topic.is_discovery_protected = false;
  EXPECT_EQ(matched(two, attributes, kMost + 1), kMost + 1);
}

}  // namespace
}  // namespace ddssec::cryptography
