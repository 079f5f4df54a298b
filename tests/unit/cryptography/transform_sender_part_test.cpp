// What a host that does not check sources gets from a protected message.
#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr CryptographyOptions kTrustingHost{.host_checks_sources = false};

GuidPrefix header_prefix(const Bytes& message) {
  return GuidPrefix::from(BytesView(message).subspan(8, 12));
}

TEST(TransformSenderPart, TypeLookup_IsHiddenFromAHostThatTrustsNoTypes) {
  for (const bool trusts : {false, true}) {
    const PropertyList property = {
        {std::string(spi::property::kTrustTypeInformation), trusts ? "true" : "false"}};
    TwoSides two(ProtectionKind::encrypt, property, kTrustingHost);
    const EntityId requests{{0x00, 0x03, 0x00, 0xc3}};
    const auto request = DataMessage{.writer = requests, .reader = {}}.octets();
    const auto opened =
        decode_message(two, encode_message(two, rtps_message({request})).value()).value();
    EXPECT_EQ(opened.at(opened.size() - request.size()), trusts ? request[0] : 0x01);
    EXPECT_TRUE(two.b.events.codes().empty());
  }
}

TEST(TransformSenderPart, MessageThatAlsoNamesAStranger_EndsBeforeItWithAnEvent) {
  for (const auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                          ProtectionKind::encrypt_with_origin_authentication}) {
    TwoSides two(kind, {}, kTrustingHost);
    const auto honest = rtps_message({data_submessage(16)});
    const auto own = header_prefix(honest);
    const auto forged =
        rtps_message({data_submessage(16), info_source(kVictim), data_submessage(8)});
    EXPECT_EQ(decode_message(two, encode_message(two, honest).value())->size(), honest.size() + 24);
    EXPECT_TRUE(two.b.events.codes().empty());
    const auto opened = decode_message(two, encode_message(two, forged).value());
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->size(), honest.size() + 24);
    EXPECT_EQ(two.b.events.codes(), std::vector{Code::info_source_mismatch});
    EXPECT_NE(two.b.events.last().find(own.to_string()), std::string::npos);
  }
}

// Cyclone DDS puts messages of several participants of one process into one message, under the key
// of one of them.
TEST(TransformSenderPart, MessageThatAlsoNamesAnotherPeer_IsReportedOnce) {
  TwoSides two(ProtectionKind::encrypt, {}, kTrustingHost);
  auto secret = shared_secret(2);
  secret.peer_prefix = kVictim;
  two.b.factory().register_matched_remote_participant(two.b.participant, {8}, {8}, secret).value();
  const auto honest = rtps_message({data_submessage(16)});
  const auto naming = [&](const GuidPrefix& other) {
    return rtps_message({data_submessage(16), info_source(other), data_submessage(8)});
  };
  for (int i = 0; i < 3; ++i) {
    const auto opened = decode_message(two, encode_message(two, naming(kVictim)).value());
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->size(), honest.size() + 24) << "what follows is still dropped";
  }
  EXPECT_EQ(two.b.events.codes(), std::vector{Code::info_source_of_peer});
  // A participant that has not authenticated does not count as such a peer.
  auto stranger = kVictim;
  stranger.octets[11] ^= 1;
  for (int i = 0; i < 2; ++i)
    ASSERT_TRUE(decode_message(two, encode_message(two, naming(stranger)).value()));
  EXPECT_EQ(two.b.events.codes(),
            (std::vector{Code::info_source_of_peer, Code::info_source_mismatch,
                         Code::info_source_mismatch}));
}

}  // namespace
}  // namespace ddssec::cryptography
