// Announcements that the host has acknowledged, in a plugin whose host accepts messages from any
// source.
#include <optional>

#include "tests/unit/cryptography/announcements.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

// A plugin whose host accepts messages from any source, and a peer that never stops announcing.
struct AcknowledgedEndpoints : ::testing::Test {
  static constexpr int kTimes = 2 * AnnouncedOctets::kMax / kUserData;

  void meet(ProtectionKind rtps) {
    two.emplace(rtps, PropertyList{}, CryptographyOptions{.host_checks_sources = false});
    auto secret = shared_secret(5);
    secret.peer_prefix = kPeer;
    for (auto* side : {&two->a, &two->b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    if (rtps != ProtectionKind::none) return two->exchange_participant_tokens();
    auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    attributes.is_builtin = true;
    ends = two->endpoints(attributes);
  }
  // Returns the acknowledgment of a host that has the sample with that number.
  static Bytes acknacks(const EntityId& writer, std::uint32_t number) {
    return of_writer(submessage_id::kAckNack, writer, {0, number + 1, 0, number});
  }
  static Bytes announces(const EntityId& writer, std::uint32_t number) {
    return DataMessage{.writer = writer, .number = number, .payload = announcement(1, kUserData)}
        .octets();
  }
  // Returns a message from the peer or to it.
  static Bytes message(const GuidPrefix& from, const Bytes& submessages) {
    Bytes out = {'R', 'T', 'P', 'S', 2, 5, 1, 16};
    append(out, from.view());
    append(out, Bytes{0x0e, 1, 12, 0});
    append(out, kPeer.view());
    append(out, submessages);
    return out;
  }
  std::optional<TwoSides> two;
  WriterToReader ends;
};

// The plugin must read the host's acknowledgments, or it would count such announcements for ever.
TEST_F(AcknowledgedEndpoints, UnderKeysOfTheirWriters_CountOnce) {
  meet(ProtectionKind::none);
  for (std::uint32_t number = 1; number <= kTimes; ++number) {
    ASSERT_TRUE(decode_submessage(
        *two, ends, encode_submessage(*two, ends, announces(kPublications, number)).value()))
        << number;
    ASSERT_TRUE(encode_reply(*two, ends, acknacks(kPublications, number)));
  }
  EXPECT_TRUE(two->b.events.codes().empty()) << two->b.events.last();
}

TEST_F(AcknowledgedEndpoints, EndpointsInProtectedMessages_CountOnce) {
  constexpr EntityId kClear{{0, 0, 3, 0xc2}};
  meet(ProtectionKind::encrypt);
  for (std::uint32_t number = 1; number <= kTimes; ++number) {
    const auto encoded = encode_message(*two, message(kPeer, announces(kClear, number)));
    const auto decoded = decode_message(*two, encoded.value());
    ASSERT_TRUE(decoded);
    ASSERT_GT(decoded->size(), kUserData) << number << ' ' << two->b.events.last();
    ASSERT_TRUE(into_bytes(1000, [&](MutableBytes out) {
      return two->b.transform().encode_rtps_message(
          two->b.participant, {&two->b.remote, 1}, message(kVictim, acknacks(kClear, number)), out);
    }));
  }
}

}  // namespace
}  // namespace ddssec::cryptography
