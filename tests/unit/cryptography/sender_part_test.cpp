#include "plugins/cryptography/sender_part.hpp"

#include <functional>
#include <future>

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/announcements.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

// A participant of the same subject.
constexpr GuidPrefix kSibling{{0x81, 2, 3, 4, 5, 6, 70, 80, 90, 100, 110, 120}};
using Token = DataMessage;
constexpr EntityId kOtherWriter{{0x00, 0x00, 0x01, 0x03}};

TEST(TokenSource, OwnSourceInEachByteOrderAndEncapsulation_IsTaken) {
  for (const bool little : {false, true}) {
    for (const std::uint8_t encoding : {0, 1, 6, 7}) {
      Token token{.little = little, .payload = generic_message(kPeer, kPeer, encoding)};
      EXPECT_TRUE(token.check_token());
      token.fragment.emplace();
      token.flags = 0;
      EXPECT_TRUE(token.check_token());
      token.flags = 0x02;
      token.inline_qos = qos(little, 8);
      EXPECT_TRUE(token.check_token());
      token.payload = generic_message(kVictim, kPeer, encoding);
      EXPECT_EQ(code_of(token.check_token()), Code::token_source_mismatch);
    }
  }
  // The token of a participant names no endpoint.
  EXPECT_TRUE((Token{.payload = generic_message(kPeer, {}, 1)}.check_token()));
}

TEST(TokenSource, AnotherSource_IsRefusedWhereverItStands) {
  for (const bool little : {false, true}) {
    Token token{.little = little, .payload = generic_message(kVictim, {}, 0)};
    const auto status = token.check_token();
    ASSERT_EQ(code_of(status), Code::token_source_mismatch);
    EXPECT_EQ(status.error().details().expected, kPeer.to_string());
    EXPECT_EQ(status.error().details().found, kVictim.to_string());
    token.payload = generic_message(kPeer, kVictim, 0);
    EXPECT_EQ(code_of(token.check_token()), Code::token_source_mismatch);
    token.flags = 0x06;
    token.inline_qos = qos(little, 8);
    EXPECT_EQ(code_of(token.check_token()), Code::token_source_mismatch);
  }
  // Each octet of the name is compared.
  for (const std::size_t begin : {4u, 84u}) {
    for (std::size_t at = begin; at < begin + 12; ++at) {
      Token token;
      token.payload[at] ^= 1;
      EXPECT_EQ(code_of(token.check_token()), Code::token_source_mismatch) << at;
    }
  }
}

// Such a message would reach all participants of the process.
TEST(TokenSource, MissingReader_IsRefused) {
  for (const auto& reader : {EntityId{}, EntityId{{0xff, 0x02, 0x02, 0xc3}}}) {
    Token token{.reader = reader};
    EXPECT_EQ(code_of(token.check_token()), Code::submessage_not_of_sender);
    token.fragment.emplace();
    token.flags = 0;
    EXPECT_EQ(code_of(token.check_token()), Code::submessage_not_of_sender);
  }
}

TEST(TokenSource, BesideAnotherAuthentication_BothNamesMustAgree) {
  Token token{.payload = generic_message(kVictim, kVictim, 1)};
  EXPECT_TRUE(token.check_token(std::nullopt));
  token.payload = generic_message(kVictim, kPeer, 1);
  EXPECT_EQ(code_of(token.check_token(std::nullopt)), Code::token_source_mismatch);
}

TEST(TokenSource, TokenCutOffAnywhere_IsRefused) {
  for (const bool little : {false, true}) {
    for (const bool has_qos : {false, true}) {
      for (const bool is_fragment : {false, true}) {
        Token token{.little = little};
        if (is_fragment) token.fragment.emplace(), token.flags = 0;
        if (has_qos) token.flags |= 0x02, token.inline_qos = qos(little, 8);
        const auto whole = token.octets();
        const auto needed = is_fragment ? whole.size() : whole.size() - token.payload.size() + 100;
        for (std::size_t size = 4; size < whole.size(); ++size) {
          const auto code = code_of(check_token_source(BytesView(whole).first(size), true, kPeer));
          if (size < needed)
            EXPECT_EQ(code, Code::token_source_unreadable) << size;
          else
            EXPECT_EQ(code, Code{}) << size;
        }
      }
    }
  }
}

TEST(TokenSource, LyingLengths_AreRefused) {
  const auto refused = [](const Token& token) {
    return code_of(token.check_token()) == Code::token_source_unreadable;
  };
  EXPECT_TRUE(refused({.to_inline_qos = 12}));  // within the header
  EXPECT_TRUE(refused({.to_inline_qos = 18}));  // no multiple of four
  EXPECT_TRUE(refused({.to_inline_qos = 60000}));
  EXPECT_TRUE(refused({.flags = 0x06, .inline_qos = qos(true, 6)}));
  EXPECT_TRUE(refused({.flags = 0x06, .inline_qos = qos(true, 60000)}));
  EXPECT_TRUE(refused({.flags = 0x06, .inline_qos = qos(true, 8, false)}));
  // This payload is encoded as a parameter list.
  EXPECT_TRUE(refused({.payload = generic_message(kPeer, kPeer, 2)}));
  EXPECT_TRUE(refused({.payload = generic_message(kPeer, kPeer, 9)}));
  EXPECT_TRUE(refused({.flags = 0, .fragment = Fragment{.first = 0}}));
  EXPECT_TRUE(refused({.flags = 0, .fragment = Fragment{.size = 96}}));
  EXPECT_TRUE(refused({.flags = 0, .fragment = Fragment{.first = 3, .size = 96}}));
  // In 32 bits, the place of this fragment would wrap around to the beginning.
  EXPECT_TRUE(
      refused({.flags = 0, .fragment = Fragment{.first = 0x01000001, .size = 256, .whole = 4096}}));
}

// A host that does not check sources keeps each fragment until all have arrived, and a hostile
// sender never sends the others.
TEST(TokenSource, SeveralFragments_AreRefused) {
  const auto refused = [](const Fragment& fragment, Bytes payload) {
    const Token token{.flags = 0, .payload = std::move(payload), .fragment = fragment};
    return code_of(token.check_token()) == Code::token_source_unreadable;
  };
  EXPECT_TRUE(refused({.first = 2, .size = 120, .whole = 160}, Bytes(40, 0x44)));
  EXPECT_TRUE(refused({.first = 2, .size = 60000, .whole = 2000000000}, Bytes(60000, 0x44)));
  EXPECT_TRUE(refused({.size = 120, .whole = 160}, generic_message(kPeer, kPeer, 1)));
  EXPECT_FALSE(refused({.size = 160, .whole = 120}, generic_message(kPeer, kPeer, 1)));
}

// Cyclone DDS reads such a message through a null pointer.
TEST(TokenSource, MissingData_IsRefused) {
  const auto code = [](const Token& token) { return code_of(token.check_token()); };
  for (const bool little : {false, true}) {
    for (const std::uint8_t flags : {0x00, 0x08, 0x0c}) {  // nothing, a key, both
      EXPECT_EQ(code({.little = little, .flags = flags}), Code::token_source_unreadable);
      const Token with_qos{.little = little,
                           .flags = static_cast<std::uint8_t>(flags | 0x02),
                           .inline_qos = qos(little, 8)};
      EXPECT_EQ(code(with_qos), Code::token_source_unreadable);
    }
    EXPECT_EQ(code({.little = little, .flags = 0, .payload = {}}), Code::token_source_unreadable);
    for (const std::uint32_t first : {1u, 2u}) {
      const Fragment piece{.first = first, .whole = 240};
      EXPECT_EQ(code({.little = little, .flags = 0x04, .fragment = piece}),
                Code::token_source_unreadable);
    }
  }
}

TEST(TokenSource, OnlyTheKeyExchange_ProtectsTokensAndNothingElse) {
  const auto token = Token{}.octets();
  EXPECT_EQ(code_of(check_token_source(token, false, kPeer)), Code::submessage_not_of_sender);
  const auto other = Token{.writer = kOtherWriter}.octets();
  EXPECT_EQ(code_of(check_token_source(other, true, kPeer)), Code::submessage_not_of_sender);
  EXPECT_TRUE(check_token_source(other, false, kPeer));
  EXPECT_TRUE(check_token_source(data_submessage(28, submessage_id::kHeartbeat), true, kPeer));
}

// ---- INFO_SRC

OneOwner walks;
Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) append(out, part);
  return out;
}

TEST(SenderPart, OwnAndSiblingSources_AreOneSender) {
  const auto content = joined({info_source(kPeer), data_submessage(16), info_source(kSibling),
                               data_submessage(8), info_source(kPeer, false), Bytes{0x01, 1, 0, 0},
                               Bytes{0x09, 0, 0, 0}, data_submessage(20)});
  const auto part = part_of_sender(content, kPeer, walks);
  EXPECT_EQ(part.size, content.size());
  EXPECT_FALSE(part.ended);
}

TEST(SenderPart, AnotherSource_EndsThePart) {
  for (const bool little : {false, true}) {
    for (const std::size_t more : {0u, 4u}) {
      const auto own = joined({info_source(kPeer), data_submessage(16)});
      const auto content = joined(
          {own, info_source(kVictim, little, more), data_submessage(16), info_source(kPeer)});
      const auto part = part_of_sender(content, kPeer, walks);
      EXPECT_EQ(part.size, own.size());
      ASSERT_TRUE(part.ended);
      EXPECT_EQ(part.ended->code(), Code::info_source_mismatch);
      EXPECT_EQ(part.ended->details().found, kVictim.to_string());
    }
  }
  // The first six octets must agree, not only five.
  auto near = kSibling;
  near.octets[5] ^= 1;
  EXPECT_TRUE(part_of_sender(info_source(near), kPeer, walks).ended);
}

TEST(SenderPart, ContentCutOffAnywhere_SpeaksForNoOther) {
  const auto own = joined({info_source(kPeer), data_submessage(16)});
  const auto content = joined({own, info_source(kVictim), data_submessage(16)});
  for (std::size_t size = 0; size <= content.size(); ++size) {
    const auto part = part_of_sender(BytesView(content).first(size), kPeer, walks);
    EXPECT_LE(part.size, std::min(size, own.size()));
    EXPECT_EQ(part.ended.has_value(), part.size < size) << size;
  }
}

struct ClosedWriters : AnnouncedEndpointsTest {
  static constexpr EntityId kClearPublications{{0x00, 0x00, 0x03, 0xc2}};
  static Bytes announced_by(const EntityId& writer) {
    return DataMessage{.writer = writer, .reader = {}, .payload = announcement(1, 8)}.octets();
  }
  SenderPart part_of(std::initializer_list<Bytes> parts) {
    return part_of_sender(joined(parts), kPeer, peers);
  }
  bool counts_for_nothing() const {
    const auto& announced = peers.peer.announced;
    return account->sum() == 0 && !announced.hides_writers() && !announced.hides_readers() &&
           !announced.has_secured(endpoint(1), true);
  }
};

// Every participant with the key of the message can write in any participant's name.
TEST_F(ClosedWriters, SampleInTheClear_IsHiddenAndCountsForNothing) {
  peers.closed = {.secure_topics = true, .clear_topics = true};
  for (const auto& writer : {kPublications, kSubscriptions, kClearPublications}) {
    auto fragment = announced_by(writer);
    fragment[0] = submessage_id::kDataFrag;
    for (const auto& sample : {announced_by(writer), fragment}) {
      const auto part = part_of({info_source(kPeer), sample, data_submessage(16)});
      EXPECT_FALSE(part.ended);
      EXPECT_EQ(part.hidden, std::vector<std::size_t>{24});
      EXPECT_TRUE(counts_for_nothing());
    }
  }
  EXPECT_EQ(announce_under(1, 7), Code{}) << "the genuine one of that number, under its own key";
}

TEST_F(ClosedWriters, HeartbeatAndGapInTheClear_SkipNoNumber) {
  peers.closed = {.secure_topics = true};
  ASSERT_EQ(announce_under(1, 7), Code{});
  const auto heartbeat = of_writer(submessage_id::kHeartbeat, kPublications, {0, 5, 0, 4, 1});
  EXPECT_EQ(part_of({info_source(kPeer), heartbeat}).hidden, std::vector<std::size_t>{24});
  ASSERT_EQ(dispose_under(2, 7, kDisposed), Code{});
  peers.peer.announced.acknowledged(*discovery_topic_of(kPublications), 3);
  EXPECT_EQ(account->sum(), 0U) << "the end of the endpoint counts: it was not skipped";
}

TEST_F(ClosedWriters, SampleInASignedGroup_IsLeftToTheKeyOfItsWriter) {
  peers.closed = {.secure_topics = true, .clear_topics = true};
  const Bytes prefix = {0x31, 1, 4, 0, 0, 0, 0, 0}, postfix = {0x32, 1, 4, 0, 0, 0, 0, 0};
  const auto part = part_of({info_source(kPeer), prefix, announced_by(kPublications), postfix});
  EXPECT_FALSE(part.ended);
  EXPECT_TRUE(part.hidden.empty());
  EXPECT_TRUE(counts_for_nothing());
}

TEST_F(ClosedWriters, SampleOfAnOpenWriter_Counts) {
  peers.closed = {.secure_topics = true};
  EXPECT_TRUE(part_of({info_source(kPeer), announced_by(kClearPublications)}).hidden.empty());
  EXPECT_TRUE(peers.peer.announced.hides_writers());
}

// The caller hides them if it hides types.
TEST(SenderPart, TypeLookups_AreFound) {
  constexpr EntityId kRequests{{0x00, 0x03, 0x00, 0xc3}}, kReplies{{0x00, 0x03, 0x01, 0xc3}};
  const auto of = [](const EntityId& writer) {
    return DataMessage{.writer = writer, .reader = {}}.octets();
  };
  const auto request = of(kRequests), other = of(kOtherWriter), reply = of(kReplies);
  auto fragment = reply;
  fragment[0] = submessage_id::kDataFrag;
  const auto content = joined({info_source(kPeer), request, other, reply, fragment});
  const auto part = part_of_sender(content, kPeer, walks);
  EXPECT_EQ(part.size, content.size());
  const auto replies = 24 + request.size() + other.size();
  EXPECT_EQ(part.lookups, (std::vector<std::size_t>{24, replies, replies + reply.size()}));
}

TEST(SenderPart, GroupReadInTwoWays_HidesNothing) {
  // SEC_PREFIX says little endian and SEC_BODY big endian, so the length is 16 octets or 4096.
  const Bytes prefix = {0x31, 1, 4, 0, 0, 0, 0, 0}, postfix = {0x32, 1, 4, 0, 0, 0, 0, 0};
  Bytes body = {0x30, 0, 16, 0};
  body.resize(20);
  auto content = joined({info_source(kPeer), prefix, body, postfix, info_source(kVictim)});
  content.resize(24 + 8 + 4 + 4096 + 8);
  const auto part = part_of_sender(content, kPeer, walks);
  EXPECT_EQ(part.size, 24u);
  ASSERT_TRUE(part.ended);
  EXPECT_EQ(part.ended->code(), Code::secure_group_malformed);
  body[1] = 1;
  const auto group = joined({info_source(kPeer), prefix, body, postfix, data_submessage(8)});
  EXPECT_EQ(part_of_sender(group, kPeer, walks).size, group.size());
}

// ---- in the plugin

constexpr CryptographyOptions kTrustingHost{.host_checks_sources = false};

TEST(TrustingHost, KeysAlreadySet_AreKept) {
  TwoSides two(ProtectionKind::encrypt, {}, kTrustingHost);
  EXPECT_TRUE(two.take_participant(two.participant_tokens().value()));  // the tokens are repeated
  const std::vector<spi::Token> others = {Insider(kAes256Gcm).token()};
  EXPECT_EQ(code_of(two.take_participant(others)), Code::keys_already_set);
  EXPECT_EQ(two.b.events.codes(), std::vector{Code::keys_already_set});
  const auto message = encode_message(two, rtps_message({data_submessage(16)})).value();
  EXPECT_TRUE(decode_message(two, message));

  const auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::encrypt);
  const auto ends = two.endpoints(attributes);
  EXPECT_TRUE(two.take_writer(ends, two.writer_tokens(ends).value()));
  EXPECT_EQ(code_of(two.take_writer(ends, others)), Code::keys_already_set);
  EXPECT_EQ(code_of(two.take_reader(ends, others)), Code::keys_already_set);
  const auto submessage = encode_submessage(two, ends, data_submessage(16)).value();
  EXPECT_TRUE(decode_submessage(two, ends, submessage));
}

TEST(TrustingHost, LaterRevisions_AreTaken) {
  TwoSides two(participant_attributes(ProtectionKind::encrypt, true), {}, kTrustingHost);
  ASSERT_TRUE(two.a.factory().revise_local_entity_keys(two.a.participant));
  EXPECT_TRUE(two.take_participant(two.participant_tokens(KeyStage::revised).value()));
}

TEST(TrustingHost, AnotherRegistration_HasOtherKeys) {
  TwoSides two(ProtectionKind::encrypt, {}, kTrustingHost);
  TwoSides::match(two.b, 9);
  const std::vector<spi::Token> others = {Insider(kAes256Gcm).token()};
  EXPECT_TRUE(two.take_participant(others));
}

TEST(TrustingHost, TokensOfThePeer_PassAndOfOthersDoNot) {
  TwoSides two(ProtectionKind::none, {}, kTrustingHost);
  auto secret = shared_secret(5);
  for (auto* side : {&two.a, &two.b}) {
    // A hostile sender does not check which participant its key tokens are for.
    if (side == &two.b) secret.peer_prefix = kPeer;
    side->remote = side->factory()
                       .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                       .value();
  }
  const auto ends = two.volatile_endpoints();
  const auto passes = [&](const Bytes& submessage) {
    return decode_submessage(two, ends, encode_submessage(two, ends, submessage).value());
  };
  EXPECT_TRUE(passes(Token{}.octets()));
  const auto forged = passes(Token{.payload = generic_message(kVictim, {}, 1)}.octets());
  EXPECT_EQ(code_of(forged), Code::token_source_mismatch);
  EXPECT_EQ(two.b.events.codes(), std::vector{Code::token_source_mismatch});
  EXPECT_EQ(code_of(passes(Token{.writer = kOtherWriter}.octets())),
            Code::submessage_not_of_sender);
}

TEST(TrustingHost, Tokens_ComeByTheKeyExchangeOnly) {
  TwoSides two(ProtectionKind::none, {}, kTrustingHost);
  const auto ends =
      two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  const auto encoded = encode_submessage(two, ends, Token{}.octets()).value();
  EXPECT_EQ(code_of(decode_submessage(two, ends, encoded)), Code::submessage_not_of_sender);
}

struct Gate final : spi::MatchGate {
  Status check(const Peer& peer) const override {
    asked.push_back(peer);
    return peer.permissions.value == 7 ? Status() : fail(Code::keys_not_permitted);
  }
  mutable std::vector<Peer> asked;
};

TEST(TrustingHost, AGate_IsAskedAboutEachMatch) {
  TwoSides two(ProtectionKind::none, {}, kTrustingHost);
  const auto gate = std::make_shared<Gate>();
  auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
  attributes.gate = gate;
  EXPECT_TRUE(two.endpoints(attributes).remote_writer);
  ASSERT_EQ(gate->asked.size(), 2u);
  EXPECT_FALSE(gate->asked[0].writes);
  EXPECT_TRUE(gate->asked[1].writes);
  // The same remote, after its permissions were judged again.
  auto& factory = two.b.factory();
  ASSERT_TRUE(
      factory.register_matched_remote_participant(two.b.participant, {7}, {6}, shared_secret()));
  const auto reader = factory.register_local_datareader(two.b.participant, {}, attributes).value();
  EXPECT_EQ(
      code_of(factory.register_matched_remote_datawriter(reader, two.b.remote, shared_secret())),
      Code::keys_not_permitted);
}

// A gate that uses the factory while it judges, as the message of another peer would.
struct BusyGate final : spi::MatchGate {
  Status check(const Peer& peer) const override {
    auto other = std::async(std::launch::async, [&] { return use(); });
    went_on = other.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
    if (!went_on) waiting = std::move(other);  // until the lock is released
    asked.push_back(peer);
    return {};
  }
  std::function<bool()> use;
  mutable bool went_on = false;
  mutable std::future<bool> waiting;
  mutable std::vector<Peer> asked;
};

// A reader whose matches a busy gate judges.
struct BusyTrustingHost : ::testing::Test {
  DatareaderCryptoHandle reader_with(std::shared_ptr<const spi::MatchGate> judge) {
    auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    attributes.gate = std::move(judge);
    return factory.register_local_datareader(two.b.participant, {}, attributes).value();
  }

  TwoSides two{ProtectionKind::none, {}, kTrustingHost};
  spi::CryptoKeyFactory& factory = two.b.factory();
  const std::shared_ptr<BusyGate> gate = std::make_shared<BusyGate>();
  const DatareaderCryptoHandle reader = reader_with(gate);
};

TEST_F(BusyTrustingHost, WhileAGateJudges_NoOtherCallWaits) {
  gate->use = [&] {
    return factory.register_local_datareader(two.b.participant, {}, {}).has_value();
  };
  EXPECT_TRUE(factory.register_matched_remote_datawriter(reader, two.b.remote, shared_secret()));
  EXPECT_TRUE(gate->went_on);
  EXPECT_EQ(gate->asked.size(), 1u);
}

TEST_F(BusyTrustingHost, PeerJudgedAnewMeanwhile_IsAskedAboutAgain) {
  gate->use = [&] {
    return factory.register_matched_remote_participant(two.b.participant, {7}, {6}, shared_secret())
        .has_value();
  };
  EXPECT_TRUE(factory.register_matched_remote_datawriter(reader, two.b.remote, shared_secret()));
  ASSERT_EQ(gate->asked.size(), 2u);
  EXPECT_EQ(gate->asked[0].permissions.value, 7);
  EXPECT_EQ(gate->asked[1].permissions.value, 6);
  // The reader is unregistered before the answer arrives.
  gate->use = [&] { return factory.unregister_datareader(reader).has_value(); };
  EXPECT_EQ(
      code_of(factory.register_matched_remote_datawriter(reader, two.b.remote, shared_secret())),
      Code::crypto_handle_unknown);
}

}  // namespace
}  // namespace ddssec::cryptography
