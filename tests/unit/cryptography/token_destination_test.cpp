// Which participant gets key tokens, and which may request fragments of them.
#include "plugins/cryptography/token_destination.hpp"

#include <gtest/gtest.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr EntityId kWriterId{{0, 0, 1, 2}}, kReaderId{{0, 0, 1, 7}};

// Returns the payload of a message from kOurs to that participant.
Bytes tokens_to(const GuidPrefix& destination, bool little = true,
                std::string_view class_id = kOfWriter) {
  return token_message({kOurs, kWriterId}, {destination, kReaderId}, fresh_tokens(), class_id,
                       little);
}

Code check(const DataMessage& message, const std::optional<GuidPrefix>& receiver = kPeer) {
  FragmentedTokens sent;
  return code_of(check_token_destination(message.octets(), receiver, sent));
}

Bytes nack_frag(std::uint32_t number, bool little = true) {
  Bytes out = {submessage_id::kNackFrag, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  append(out, rtps::kVolatileMessageReader.view());
  append(out, rtps::kVolatileMessageWriter.view());
  append(out, 0, 4, little);
  append(out, number, 4, little);
  for (const std::uint32_t word : {1u, 1u, 0x80000000u, 1u}) append(out, word, 4, little);
  out[little ? 2 : 3] = static_cast<std::uint8_t>(out.size() - 4);
  return out;
}

TEST(TokenDestination, TheReceiver_GetsItsTokens) {
  for (const bool little : {true, false})
    for (const auto class_id : {kOfParticipant, kOfWriter})
      EXPECT_EQ(check({.little = little, .payload = tokens_to(kPeer, little, class_id)}), Code{});
}

TEST(TokenDestination, AnotherParticipant_IsRefusedWithBothNames) {
  for (const auto class_id : {kOfParticipant, kOfWriter})
    EXPECT_EQ(check({.payload = tokens_to(kVictim, true, class_id)}),
              Code::token_destination_refused);
  FragmentedTokens sent;
  const auto status =
      check_token_destination(DataMessage{.payload = tokens_to(kVictim)}.octets(), kPeer, sent);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().details().field, "destination_participant_guid");
  EXPECT_EQ(status.error().details().expected, kPeer.to_string());
  EXPECT_EQ(status.error().details().found, kVictim.to_string());
}

// The standard allows a message for all participants. Key tokens never are for all.
TEST(TokenDestination, AllParticipants_AreRefused) {
  EXPECT_EQ(check({.payload = tokens_to(GuidPrefix{})}), Code::token_destination_refused);
}

TEST(TokenDestination, DestinationWithEachOctetChanged_IsRefused) {
  for (std::size_t at = 0; at < GuidPrefix::size; ++at) {
    auto payload = tokens_to(kPeer);
    payload[52 + at] ^= 1;
    EXPECT_EQ(check({.payload = payload}), Code::token_destination_refused) << at;
  }
}

TEST(TokenDestination, BesideAnotherAuthentication_PassesIfItCanBeRead) {
  EXPECT_EQ(check({.payload = tokens_to(kVictim)}, std::nullopt), Code{});
  EXPECT_EQ(check({.payload = Bytes(63)}, std::nullopt), Code::token_destination_refused);
}

TEST(TokenDestination, CutOffAnywhere_IsRefused) {
  for (const bool is_fragment : {false, true}) {
    DataMessage message{.payload = tokens_to(kPeer)};
    const auto size = message.payload.size();
    if (is_fragment) {
      message.flags = 0;
      message.fragment = {.size = static_cast<std::uint16_t>(size),
                          .whole = static_cast<std::uint32_t>(size)};
    }
    const auto whole = message.octets();
    const auto needed = whole.size() - size + 64;
    for (std::size_t cut = 4; cut < whole.size(); ++cut) {
      FragmentedTokens sent;
      EXPECT_EQ(code_of(check_token_destination(BytesView(whole).first(cut), kPeer, sent)),
                cut < needed ? Code::token_destination_refused : Code{})
          << cut;
    }
  }
}

TEST(TokenDestination, MessageWithoutDataOrInAnotherEncoding_IsRefused) {
  for (const std::uint8_t flags : {0x00, 0x08, 0x0c})  // no payload, a key, both
    EXPECT_EQ(check({.flags = flags, .payload = tokens_to(kPeer)}),
              Code::token_destination_refused);
  auto list = tokens_to(kPeer);
  list[1] = 3;  // PL_CDR
  EXPECT_EQ(check({.payload = list}), Code::token_destination_refused);
}

TEST(TokenDestination, OtherSubmessages_Pass) {
  FragmentedTokens sent;
  for (const auto id : {submessage_id::kHeartbeat, submessage_id::kGap, submessage_id::kAckNack,
                        submessage_id::kNackFrag})
    EXPECT_TRUE(check_token_destination(data_submessage(28, id), kPeer, sent)) << +id;
}

// A host that is configured with small fragments sends the first fragment first.
TEST(TokenDestination, LaterFragments_FollowTheirFirstOneOnly) {
  const auto payload = tokens_to(kPeer);
  const auto whole = static_cast<std::uint32_t>(payload.size());
  const auto fragment = [&](std::uint32_t number, std::uint32_t first, const GuidPrefix& to) {
    auto octets = first == 1 ? tokens_to(to) : Bytes(100, 0x44);
    octets.resize(100);
    return DataMessage{.flags = 0,
                       .number = number,
                       .payload = std::move(octets),
                       .fragment = Fragment{.first = first, .size = 100, .whole = whole}}
        .octets();
  };
  FragmentedTokens sent;
  const auto code = [&](const Bytes& octets) {
    return code_of(check_token_destination(octets, kPeer, sent));
  };
  EXPECT_EQ(code(fragment(1, 2, kPeer)), Code::token_destination_refused);
  EXPECT_EQ(code(fragment(1, 1, kVictim)), Code::token_destination_refused);
  EXPECT_EQ(code(fragment(1, 2, kPeer)), Code::token_destination_refused);
  EXPECT_EQ(code(fragment(2, 1, kPeer)), Code{});
  EXPECT_EQ(code(fragment(2, 2, kPeer)), Code{});
  EXPECT_EQ(code(fragment(1, 2, kPeer)), Code::token_destination_refused);
  EXPECT_TRUE(check_fragment_request(nack_frag(2), sent));
  EXPECT_EQ(code_of(check_fragment_request(nack_frag(1), sent)), Code::token_fragment_not_sent);
}

TEST(FragmentRequest, MessageThatIsNotInFragments_IsRefused) {
  const FragmentedTokens none;
  for (const bool little : {true, false}) {
    const auto request = nack_frag(1, little);
    for (std::size_t size = 4; size <= request.size(); ++size)
      EXPECT_EQ(code_of(check_fragment_request(BytesView(request).first(size), none)),
                Code::token_fragment_not_sent)
          << size;
  }
  for (const auto id : {submessage_id::kAckNack, submessage_id::kHeartbeat, submessage_id::kGap})
    EXPECT_TRUE(check_fragment_request(data_submessage(28, id), none)) << +id;
}

// The plugin of a host. The insider is its authenticated peer.
struct Host {
  explicit Host(bool host_checks)
      : two(ProtectionKind::none, {}, {.host_checks_sources = host_checks}) {
    auto secret = shared_secret(5);
    secret.peer_prefix = kPeer;
    for (auto* side : {&two.a, &two.b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    ends = two.volatile_endpoints();
  }
  TwoSides two;
  WriterToReader ends;
};

// T46 (docs/attacks.md): Cyclone DDS answers any NACK_FRAG of a matched reader, whatever
// participant the message is for.
TEST(KeyTokens, TokensForAnotherParticipant_AreNotEncryptedForAPeer) {
  Host host(false);
  auto& events = host.two.a.events;
  const auto encode = [&](const GuidPrefix& to) {
    return code_of(
        encode_submessage(host.two, host.ends, DataMessage{.payload = tokens_to(to)}.octets()));
  };
  EXPECT_EQ(encode(kPeer), Code{});
  EXPECT_EQ(events.codes(), std::vector<Code>());
  EXPECT_EQ(encode(kVictim), Code::token_destination_refused);
  ASSERT_EQ(events.codes(), std::vector{Code::token_destination_refused});
  EXPECT_EQ(events.all.back().guid, (Guid{kPeer, kEntityIdParticipant}.to_string()));
  EXPECT_EQ(encode(kPeer), Code{});
}

TEST(KeyTokens, AskedForByNackFrag_DoNotReachTheHost) {
  for (const bool host_checks : {false, true}) {
    Host host(host_checks);
    const auto asked = encode_reply(host.two, host.ends, nack_frag(1)).value();
    EXPECT_EQ(code_of(decode_reply(host.two, host.ends, asked)), Code::token_fragment_not_sent);
    ASSERT_EQ(host.two.a.events.codes(), std::vector{Code::token_fragment_not_sent});
    EXPECT_EQ(host.two.a.events.all.back().guid, (Guid{kPeer, kEntityIdParticipant}.to_string()));
  }
}

// An honest peer has not received the first fragment, which has that many octets, and requests it
// again.
void expect_sent_again(Host& host, std::uint16_t fragment_size) {
  auto payload = tokens_to(kPeer);
  const auto whole = static_cast<std::uint32_t>(payload.size());
  payload.resize(fragment_size);
  const DataMessage first{.flags = 0,
                          .payload = std::move(payload),
                          .fragment = Fragment{.size = fragment_size, .whole = whole}};
  ASSERT_TRUE(encode_submessage(host.two, host.ends, first.octets()));
  const auto asked = encode_reply(host.two, host.ends, nack_frag(1)).value();
  EXPECT_TRUE(decode_reply(host.two, host.ends, asked));
  EXPECT_EQ(host.two.a.events.codes(), std::vector<Code>());
}

TEST(KeyTokens, TokensInFragments_AreSentAgainToTheirReceiver) {
  Host host(false);
  expect_sent_again(host, 100);
}

// The fragments of an embedded participant may end before the destination. It has a volatile writer
// for each peer, so a message cannot reach another peer.
TEST(KeyTokens, TinyFragmentsOfAnEmbeddedHost_AreSent) {
  Host host(true);
  expect_sent_again(host, 20);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
