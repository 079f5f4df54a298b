// Matches that a gate judges, and properties that decide how keys are made.
#include <gtest/gtest.h>

#include "base/writer.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/trusting_host.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::trusting_host {
namespace {

using namespace testing;

constexpr EntityId kSecurePublications{{0xff, 0, 3, 0xc2}};

struct Gate final : spi::MatchGate {
  Status check(const Peer& peer) const override {
    hides.push_back(peer.hides_endpoints);
    return {};
  }
  mutable std::vector<bool> hides;
};

// A reader of a topic with access control and protected discovery.
struct Gated {
  Gated() : two({.discovery = ProtectionKind::encrypt}, {}, {.host_checks_sources = false}) {
    auto secret = shared_secret(5);
    for (auto* side : {&two.a, &two.b}) {
      // A hostile sender does not check which participant its key tokens are for.
      if (side == &two.b) secret.peer_prefix = kPeer;
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    }
    auto builtin = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    builtin.is_builtin = true;
    discovery = two.endpoints(builtin);
    ends = two.volatile_endpoints();
  }
  Code announce(const EntityId& writer, bool hides) {
    Bytes list = {0, 3, 0, 0, 0x5a, 0, 16, 0};
    append(list, kPeer.view());
    append(list, writer.view());
    if (!hides) append(list, Bytes{4, 0x10, 8, 0, 0, 0, 0, 0x80, 0, 0, 0, 0x80});
    append(list, Bytes{1, 0, 0, 0});
    const auto octets =
        DataMessage{.writer = kSecurePublications, .number = ++number, .payload = list}.octets();
    return code_of(
        decode_submessage(two, discovery, encode_submessage(two, discovery, octets).value()));
  }
  Code end(const EntityId& writer) {
    Bytes list = {0, 3, 0, 0, 0x5a, 0, 16, 0};
    append(list, kPeer.view());
    append(list, writer.view());
    append(list, Bytes{1, 0, 0, 0});
    const Bytes disposed = {0x71, 0, 4, 0, 0, 0, 0, 1, 1, 0, 0, 0};
    const DataMessage message{.writer = kSecurePublications,
                              .flags = 0x06,
                              .number = ++number,
                              .inline_qos = disposed,
                              .payload = list};
    return code_of(decode_submessage(two, discovery,
                                     encode_submessage(two, discovery, message.octets()).value()));
  }
  // The host acknowledges everything that the secure discovery announced.
  void acknowledge() {
    Bytes acknack = {submessage_id::kAckNack, 1, 24, 0};
    append(acknack, EntityId{{0xff, 0, 3, 0xc7}}.view());
    append(acknack, kSecurePublications.view());
    append(acknack, 0, 4, true);
    append(acknack, number + 1, 4, true);
    append(acknack, 0, 4, true);
    append(acknack, 1, 4, true);
    ASSERT_TRUE(encode_reply(two, discovery, acknack));
  }
  WriterToReader match() {
    auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    attributes.topic.is_discovery_protected = true;
    attributes.gate = gate;
    return two.endpoints(attributes);
  }
  // The tokens of the peer's writer come by a ticket.
  Code take(const WriterToReader& user) {
    const auto tokens = two.writer_tokens(user).value();
    const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens);
    const auto octets = DataMessage{.number = 1, .payload = payload}.octets();
    const auto out = decode_submessage(two, ends, encode_submessage(two, ends, octets).value());
    return code_of(two.take_writer(user, Receiver::tokens_in(out.value())));
  }
  TwoSides two;
  WriterToReader discovery, ends;
  std::shared_ptr<Gate> gate = std::make_shared<Gate>();
  std::uint32_t number = 0;
};

TEST(MatchGate, PeerThatHidesAWriter_IsSaidToHide) {
  Gated gated;
  EXPECT_EQ(gated.announce(kWriter, false), Code{});
  gated.match();
  EXPECT_EQ(gated.gate->hides, (std::vector<bool>{false, false}));
  EXPECT_EQ(gated.announce({{0, 0, 2, 2}}, true), Code{});
  gated.match();
  EXPECT_EQ(gated.gate->hides, (std::vector<bool>{false, false, false, true}))
      << "of its readers it hides none";
}

TEST(MatchGate, WriterNotAnnouncedInTheSecureDiscovery_GetsNoMatch) {
  Gated gated;
  const auto user = gated.match();
  EXPECT_EQ(gated.take(user), Code::keys_not_permitted);
  EXPECT_EQ(gated.two.b.events.codes(), std::vector{Code::keys_not_permitted});
}

// The application of an honest peer may have deleted the writer, so no event accuses the peer.
TEST(MatchGate, KeysOfAWriterThatHasEnded_AreRefusedWithoutAnEvent) {
  Gated gated;
  EXPECT_EQ(gated.announce(kWriter, false), Code{});
  const auto user = gated.match();
  EXPECT_EQ(gated.end(kWriter), Code{});
  gated.acknowledge();
  EXPECT_EQ(gated.take(user), Code::keys_not_permitted);
  EXPECT_TRUE(gated.two.b.events.codes().empty());
}

TEST(MatchGate, WriterAnnouncedInTheSecureDiscovery_Matches) {
  Gated gated;
  EXPECT_EQ(gated.announce(kWriter, false), Code{});
  EXPECT_EQ(gated.take(gated.match()), Code{});
}

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kNone = ProtectionKind::none;

TEST(CryptoProperties, KeySizesOtherThan128And256_AreRefused) {
  TwoSides two;
  const auto attributes = endpoint_attributes(kEncrypt, kNone);
  const auto kind_with = [&](const PropertyList& properties) {
    const auto e = two.endpoints(attributes, properties);
    const auto tokens = two.writer_tokens(e);
    return read_crypto_token(tokens->front())->kind;
  };
  EXPECT_EQ(kind_with({}), kAes256Gcm);
  EXPECT_EQ(kind_with(key_size("256")), kAes256Gcm);
  EXPECT_EQ(kind_with(key_size("128")), kAes128Gcm);
  for (const auto* const bad : {"", "192", "128 ", "0128", "AES256"})
    EXPECT_EQ(code_of(two.a.factory().register_local_datawriter(two.a.participant, key_size(bad),
                                                                attributes)),
              Code::invalid_property);
  EXPECT_EQ(code_of(two.a.factory().register_local_participant({}, {}, key_size("64"), {})),
            Code::invalid_property);
}

TEST(CryptoProperties, AnEmptySharedSecret_IsRefused) {
  TwoSides two;
  EXPECT_EQ(code_of(two.a.factory().register_matched_remote_participant(two.a.participant, {9}, {},
                                                                        spi::SharedSecret{})),
            Code::length_out_of_range);
}

}  // namespace
}  // namespace ddssec::cryptography::trusting_host
