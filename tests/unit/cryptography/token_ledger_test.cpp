#include "plugins/cryptography/token_ledger.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;
using std::chrono::seconds;

constexpr EntityId kWriter{{0, 0, 1, 2}}, kReader{{0, 0, 1, 7}}, kOtherReader{{0, 0, 2, 7}};
constexpr GuidPrefix kOurs{{0x90, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr std::string_view kOfParticipant = "dds.sec.participant_crypto_tokens";
constexpr std::string_view kOfWriter = "dds.sec.datawriter_crypto_tokens";

/// Other ones each time.
std::vector<spi::Token> fresh_tokens() {
  static std::uint8_t number = 0;
  auto token = Insider(kAes256Gcm).token();
  token.binary_properties.at(0).value.back() = ++number;
  return {token};
}

void append_guid(Bytes& out, const Guid& guid) { append(out, guid.octets()); }

/// ParticipantGenericMessage with key tokens.
Bytes token_message(const Guid& remote, const Guid& local, std::span<const spi::Token> tokens,
                    std::string_view class_id = kOfWriter, bool little = true) {
  const bool of_participant = class_id == kOfParticipant;
  Writer writer(little ? Endian::little : Endian::big);
  Bytes begin;
  append_guid(begin, {remote.prefix, {}});
  begin.resize(48, 0);
  append_guid(begin, {local.prefix, kEntityIdParticipant});
  append_guid(begin, of_participant ? Guid{} : local);
  append_guid(begin, of_participant ? Guid{} : remote);
  writer.write_bytes(begin);
  writer.write_string(class_id);
  writer.write_aligned(static_cast<std::uint32_t>(tokens.size()));
  for (const auto& one : tokens) spi::write_token(writer, one);
  Bytes out = {0, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  append(out, writer.take());
  out.resize(padded(out.size()));
  return out;
}

/// What the host does: messages go in, and it comes back with tokens.
struct Host {
  std::vector<spi::Token> tokens = fresh_tokens();
  Guid remote{kPeer, kWriter};
  Guid local{kOurs, kReader};
  std::uint64_t exchange = 1;
  TokenLedger ledger;
  seconds now{1000};

  Code note(std::uint64_t number) {
    return code_of(ledger.note({remote, local, number, digest_of(tokens), 0}, exchange, now));
  }
};

TEST(TokenLedger, ASecondMessageWaitsForTheUseOfTheFirst) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  EXPECT_EQ(host.note(2), Code::crypto_tokens_repeated);
  host.ledger.note_used(host.tokens);
  EXPECT_EQ(host.note(2), Code{});  // other keys, or the same
  EXPECT_EQ(host.note(3), Code::crypto_tokens_repeated);
}

TEST(TokenLedger, ARetransmissionPasses) {
  Host host;
  EXPECT_EQ(host.note(5), Code{});
  EXPECT_EQ(host.note(5), Code{});
  EXPECT_EQ(host.note(4), Code::crypto_tokens_repeated);  // the host would take it, and then 5
  host.ledger.note_used(host.tokens);
  EXPECT_EQ(host.note(5), Code{});
  EXPECT_EQ(host.note(4), Code{});  // it took 4 before 5
  EXPECT_EQ(host.note(6), Code{});  // neither made it wait
}

TEST(TokenLedger, TheSameNumberWithOtherTokensIsNoRetransmission) {
  Host host;
  EXPECT_EQ(host.note(5), Code{});
  host.tokens = fresh_tokens();
  EXPECT_EQ(host.note(5), Code::crypto_tokens_repeated);
}

TEST(TokenLedger, AnotherExchangeCountsItsNumbersAnew) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Code::crypto_tokens_repeated);
  host.ledger.note_used(host.tokens);
  EXPECT_EQ(host.note(1), Code{});
  EXPECT_EQ(host.note(2), Code::crypto_tokens_repeated);
}

TEST(TokenLedger, AfterSixMinutesTheHostHoldsNothing) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.now += TokenLedger::kMemory - seconds(1);
  EXPECT_EQ(host.note(2), Code::crypto_tokens_repeated);
  host.now += seconds(1);
  EXPECT_EQ(host.note(2), Code{});
  EXPECT_EQ(host.ledger.size(), 1u);
}

TEST(TokenLedger, OtherEndpointsAreOthers) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.local.entity = kOtherReader;
  EXPECT_EQ(host.note(2), Code{});
  host.remote.prefix = kVictim;
  EXPECT_EQ(host.note(3), Code{});
}

/// One use of two that look alike says nothing about either.
TEST(TokenLedger, TheSameTokensForTwoAreUsedTwice) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.local.entity = kOtherReader;
  EXPECT_EQ(host.note(2), Code{});
  host.ledger.note_used(host.tokens);
  EXPECT_EQ(host.note(3), Code::crypto_tokens_repeated);
  host.ledger.note_used(host.tokens);
  EXPECT_EQ(host.note(3), Code{});
}

TEST(TokenLedger, AUseDoesNotPassToAnotherByAge) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.now += seconds(200);
  host.local.entity = kOtherReader;
  EXPECT_EQ(host.note(2), Code{});
  host.ledger.note_used(host.tokens);
  host.now += seconds(200);  // the first is old
  EXPECT_EQ(host.note(3), Code::crypto_tokens_repeated);
}

TEST(TokenLedger, UnknownTokensAreNobodys) {
  Host host;
  EXPECT_EQ(host.note(1), Code{});
  host.ledger.note_used(fresh_tokens());
  host.ledger.note_used({});
  EXPECT_EQ(host.note(2), Code::crypto_tokens_repeated);
}

TEST(TokenLedger, HoldsSoManyOfOneCertificate) {
  Host host;
  const auto note = [&](std::size_t number) {
    host.remote.entity.octets[1] = static_cast<std::uint8_t>(number >> 8);
    host.remote.entity.octets[2] = static_cast<std::uint8_t>(number);
    return host.note(number);
  };
  for (std::size_t i = 1; i <= TokenLedger::kMostPending; ++i) {
    host.remote.prefix.octets[11] = static_cast<std::uint8_t>(i % 3);  // of several participants
    ASSERT_EQ(note(i), Code{});
  }
  EXPECT_EQ(note(TokenLedger::kMostPending + 1), Code::crypto_tokens_crowded);
  EXPECT_EQ(host.ledger.size(), TokenLedger::kMostPending);
  host.remote.prefix = kVictim;
  EXPECT_EQ(note(1), Code{});
  host.remote.prefix = kPeer;
  host.now += TokenLedger::kMemory;
  EXPECT_EQ(note(1), Code{});
  EXPECT_EQ(host.ledger.size(), 1u);
}

TEST(TokenLedger, ForgetsUsedOnesInTime) {
  Host host;
  for (std::uint64_t i = 1; i <= 4 * TokenLedger::kMostPending; ++i) {
    host.remote.entity.octets[1] = static_cast<std::uint8_t>(i >> 8);
    host.remote.entity.octets[2] = static_cast<std::uint8_t>(i);
    ASSERT_EQ(host.note(i), Code{});
    host.ledger.note_used(host.tokens);
    ASSERT_LE(host.ledger.size(), 2 * TokenLedger::kMostPending);
  }
}

// ---- reading

std::optional<TokenMessage> read(const Bytes& payload) {
  const auto octets = DataMessage{.number = 9, .payload = payload}.octets();
  const auto piece = read_data_piece(octets);
  return read_token_message(*piece).value();
}

TEST(TokenMessage, SaysWhoseTokensTheyAreAndForWhom) {
  const auto tokens = fresh_tokens();
  for (const bool little : {false, true}) {
    const Guid remote{kPeer, kWriter}, local{kOurs, kReader};
    for (const auto class_id : {kOfWriter, std::string_view("dds.sec.datareader_crypto_tokens")}) {
      const auto payload = token_message(remote, local, tokens, class_id, little);
      const auto message = read(payload);
      ASSERT_TRUE(message);
      EXPECT_EQ(message->remote, remote);
      EXPECT_EQ(message->local, local);
      EXPECT_EQ(message->number, 9u);
      EXPECT_EQ(message->tokens, digest_of(tokens));
      EXPECT_EQ(payload[message->class_at], 'd');
    }
    const auto message = read(token_message(remote, local, tokens, kOfParticipant, little));
    ASSERT_TRUE(message);
    EXPECT_EQ(message->remote, (Guid{kPeer, kEntityIdParticipant}));
    EXPECT_EQ(message->local, (Guid{kOurs, kEntityIdParticipant}));
    EXPECT_FALSE(read(token_message(remote, local, tokens, "dds.sec.auth", little)));
  }
}

TEST(TokenMessage, CutOffAnywhereIsRefused) {
  const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, fresh_tokens());
  for (std::size_t size = 100; size + 4 < payload.size(); ++size) {
    const auto octets =
        DataMessage{.payload = Bytes(payload.begin(), payload.begin() + static_cast<long>(size))}
            .octets();
    const auto piece = read_data_piece(octets);
    EXPECT_EQ(code_of(read_token_message(*piece)), Code::token_source_unreadable) << size;
  }
}

// ---- in the engine

struct Engine {
  explicit Engine(bool host_checks)
      : two(ProtectionKind::none, {}, {.host_checks_sources = host_checks}) {
    authenticate(5);
    user = two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  }
  void authenticate(std::uint8_t seed) {
    auto secret = shared_secret(seed);
    secret.peer_prefix = kPeer;
    for (auto* side : {&two.a, &two.b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    ends = two.volatile_endpoints();
  }
  /// Does it come to the host as what it is?
  bool passes(std::uint32_t number, std::span<const spi::Token> tokens) {
    const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens);
    const auto octets = DataMessage{.number = number, .payload = payload}.octets();
    const auto out = decode_submessage(two, ends, encode_submessage(two, ends, octets).value());
    EXPECT_TRUE(out);
    EXPECT_EQ(out->size(), octets.size());
    return *out == octets;
  }
  TwoSides two;
  WriterToReader ends;
  WriterToReader user;
};

TEST(TrustingHost, GetsTokensAgainOnceItUsedTheFormer) {
  Engine engine(false);
  const auto tokens = engine.two.writer_tokens(engine.user).value();
  EXPECT_TRUE(engine.passes(1, tokens));
  EXPECT_TRUE(engine.passes(1, tokens));
  EXPECT_FALSE(engine.passes(2, tokens));
  EXPECT_EQ(engine.two.b.events.codes, std::vector{Code::crypto_tokens_repeated});
  EXPECT_TRUE(engine.two.take_writer(engine.user, tokens));
  EXPECT_TRUE(engine.passes(3, tokens));
  engine.authenticate(6);  // again, after it was lost
  EXPECT_FALSE(engine.passes(3, tokens));
  engine.two.b.clock.advance(TokenLedger::kMemory);
  EXPECT_TRUE(engine.passes(4, tokens));
}

TEST(TrustingHost, GetsOneMessageThatItDoesNotKnowInsteadOfTheSecond) {
  Engine engine(false);
  const auto tokens = engine.two.writer_tokens(engine.user).value();
  EXPECT_TRUE(engine.passes(1, tokens));
  const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens);
  const auto octets = DataMessage{.number = 2, .payload = payload}.octets();
  const auto out = decode_submessage(engine.two, engine.ends,
                                     encode_submessage(engine.two, engine.ends, octets).value());
  ASSERT_TRUE(out);
  auto expected = octets;
  expected[24 + 104] = '-';
  EXPECT_EQ(*out, expected);
}

TEST(CheckingHost, GetsTokensAsTheyCome) {
  Engine engine(true);
  const auto tokens = engine.two.writer_tokens(engine.user).value();
  EXPECT_TRUE(engine.passes(1, tokens));
  EXPECT_TRUE(engine.passes(2, tokens));
}

}  // namespace
}  // namespace ddssec::cryptography
