// Key tokens that our endpoints wait for although the peer believes that it has sent them.
#include "plugins/cryptography/awaited_tokens.hpp"

#include <gtest/gtest.h>

#include "base/writer.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;
using std::chrono::minutes;
using std::chrono::seconds;
using Kind = TokenDecision::Kind;

constexpr EntityId kWriter{{0, 0, 1, 2}}, kReader{{0, 0, 1, 7}};
constexpr std::string_view kOfReader = "dds.sec.datareader_crypto_tokens";

// A host whose sessions are checked once a second.
struct Host {
  TokenKey key{{kPeer, kWriter}, {kOurs, kReader}};
  std::uint64_t exchange = 1;
  std::uint64_t number = 0;
  TokenLedger ledger;
  std::chrono::nanoseconds now = seconds(1000);
  Ticket ticket = {};

  // The peer's tokens arrive, and the host takes them.
  Kind tokens_come() {
    const TokenMessage message{key.remote, key.local, ++number, false, fresh_tokens(), 0, 0};
    const auto passage = ledger.note(message, {exchange}, false, now).value();
    if (passage.kind == Kind::ticket) ticket = passage.ticket;
    ledger.acknowledged(exchange, number + 1, now);
    return passage.kind;
  }
  bool comes_with_ticket() {
    auto tokens = fresh_tokens();
    std::ranges::copy(ticket.octets, tokens[0].binary_properties.at(0).value.begin());
    return ledger.redeem(tokens, {.exchange = exchange}).has_value();
  }
  void match() { ledger.await(exchange, key, now); }
  // Returns how often the session is found stranded.
  unsigned pass(seconds time) {
    unsigned times = 0;
    for (seconds waited{}; waited < time; ++waited)
      times += ledger.poll_stranded(exchange, now += seconds(1)) ? 1 : 0;
    return times;
  }
  void begin_anew() {
    ledger.end(exchange++, now);
    number = 0;
  }
};

TEST(AwaitedTokensTest, DroppedBeforeTheMatch_StrandTheSessionOnce) {
  for (const auto held_back : {seconds(310), seconds(365), seconds(800), seconds(7200)}) {
    Host host;
    EXPECT_EQ(host.tokens_come(), Kind::ticket);
    EXPECT_EQ(host.pass(held_back), 0u) << "nothing waits";
    host.match();
    EXPECT_EQ(host.pass(seconds(19)), 0u);
    EXPECT_EQ(host.pass(seconds(2)), 1u) << held_back.count();
    host.begin_anew();
    EXPECT_EQ(host.tokens_come(), Kind::ticket) << "at once";
    host.match();
    EXPECT_TRUE(host.comes_with_ticket());
    EXPECT_EQ(host.pass(seconds(2000)), 0u);
  }
}

TEST(AwaitedTokensTest, HostComesWithTheTicket_NothingIsStranded) {
  Host host;
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  EXPECT_EQ(host.pass(seconds(310)), 0u);
  host.match();
  EXPECT_TRUE(host.comes_with_ticket());
  EXPECT_EQ(host.pass(minutes(20)), 0u);
  host.match();  // the host sent our own tokens later than it used the ticket
  EXPECT_EQ(host.pass(minutes(20)), 0u);
}

// A peer that refuses our endpoint never sends tokens for it. The tokens that we keep are for
// another endpoint.
TEST(AwaitedTokensTest, PeerNeverSendsThem_NothingIsStranded) {
  Host host;
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  EXPECT_EQ(host.pass(seconds(310)), 0u);
  host.key.local.entity.octets[2] = 9;
  host.match();
  EXPECT_EQ(host.pass(minutes(60)), 0u);
}

TEST(AwaitedTokensTest, TokensOfAnotherSession_StrandNothing) {
  Host host;
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  EXPECT_EQ(host.pass(seconds(310)), 0u);
  host.match();
  host.begin_anew();
  EXPECT_EQ(host.pass(minutes(20)), 0u);
}

// The host holds the message back until a missing one arrives, so it may still use the ticket.
TEST(AwaitedTokensTest, HostHasNotTakenThem_AreNotLost) {
  Host host;
  const TokenMessage message{host.key.remote, host.key.local, 7, false, fresh_tokens(), 0, 0};
  EXPECT_EQ(host.ledger.note(message, {1}, false, host.now)->kind, Kind::ticket);
  EXPECT_EQ(host.pass(seconds(310)), 0u);
  host.match();
  EXPECT_EQ(host.pass(seconds(100)), 0u);
  host.ledger.acknowledged(1, 8, host.now);
  EXPECT_EQ(host.pass(seconds(2)), 1u);
}

// The host dropped the peer before it took the message with the ticket.
TEST(AwaitedTokensTest, BehindATicketThatTheHostNeverHad_AreFoundWithinSeconds) {
  Host host;
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  host.begin_anew();
  host.match();
  EXPECT_EQ(host.tokens_come(), Kind::hidden);
  EXPECT_EQ(host.pass(seconds(25)), 1u);
  host.begin_anew();
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  host.match();
  EXPECT_TRUE(host.comes_with_ticket());
  EXPECT_EQ(host.pass(minutes(30)), 0u);
}

// The ten reviews that a process missed while it was stopped do not count.
TEST(AwaitedTokensTest, AProcessThatWasStopped_HasNotWaited) {
  Host host;
  EXPECT_EQ(host.tokens_come(), Kind::ticket);
  EXPECT_EQ(host.pass(seconds(310)), 0u);
  host.match();
  host.now += seconds(30);
  EXPECT_EQ(host.pass(seconds(5)), 0u);
  EXPECT_TRUE(host.comes_with_ticket());
  EXPECT_EQ(host.pass(seconds(60)), 0u);
}

TEST(AwaitedTokensTest, CertificateWithoutRoom_FindsRoomForAwaitedOnes) {
  Host host;
  for (std::uint64_t i = 0; i < TokenLedger::kMaxPending; ++i) {
    auto other = host.key.remote;
    other.entity = {{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 5, 2}};
    ASSERT_TRUE(host.ledger.note(
        {other, host.key.local, ++host.number, false, fresh_tokens(), 0, 0}, {1}, false, host.now));
  }
  const TokenMessage message{host.key.remote, host.key.local, 90000, false, fresh_tokens(), 0, 0};
  EXPECT_EQ(code_of(host.ledger.note(message, {1}, false, host.now)), Code::crypto_tokens_crowded);
  host.match();
  EXPECT_EQ(host.ledger.note(message, {1}, false, host.now)->kind, Kind::ticket);
}

TEST(AwaitedTokensTest, TooManyAwaited_AreNotKept) {
  AwaitedTokens awaited;
  TokenKey key{};
  for (std::size_t i = 0; i <= AwaitedTokens::kMax; ++i) {
    key.remote.entity = {{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i),
                          static_cast<std::uint8_t>(i >> 16), 2}};
    awaited.await(1, key, {});
  }
  EXPECT_FALSE(awaited.contains(1, key));
  awaited.end(1);
  awaited.await(2, key, {});
  EXPECT_TRUE(awaited.contains(2, key));
}

// The plugin at `b`. Its host sends our own tokens once it has matched two endpoints.
struct Receiver {
  explicit Receiver(spi::CipherMask peer_ciphers = spi::kAllCiphers)
      : two(ProtectionKind::none, {}, {.host_checks_sources = false}) {
    auto secret = shared_secret(5, peer_ciphers);
    for (auto* side : {&two.a, &two.b}) {
      // A hostile sender does not check which participant its key tokens are for.
      if (side == &two.b) secret.peer_prefix = kPeer;
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    }
    to_b = two.volatile_endpoints();
    own = writer(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none),
                 builtin_endpoint(kVolatileWriter));
  }
  struct OwnWriter {
    DatawriterCryptoHandle writer;
    DatareaderCryptoHandle reader;
  };
  OwnWriter writer(const EndpointSecurityAttributes& attributes,
                   const PropertyList& properties = {}) {
    auto& factory = two.b.factory();
    const auto made =
        factory.register_local_datawriter(two.b.participant, properties, attributes).value();
    return {made,
            factory.register_matched_remote_datareader(made, two.b.remote, shared_secret(), false)
                .value()};
  }
  // The host takes a ticket for tokens of the peer, and drops it after five minutes.
  void drop_ticket(const EntityId& remote, const EntityId& local,
                   std::span<const spi::Token> tokens, std::string_view class_id) {
    const auto payload = token_message({kPeer, remote}, {kOurs, local}, tokens, class_id);
    const auto octets = DataMessage{.number = ++number, .payload = payload}.octets();
    const auto out =
        decode_submessage(two, to_b, encode_submessage(two, to_b, octets).value()).value();
    EXPECT_EQ(out[24 + 104], 'd');
    Writer ack(Endian::little, 32);
    ack.write(std::uint32_t{24 << 16 | 1 << 8 | 6});
    ack.write_bytes(kTokenReader.view());
    ack.write_bytes(kTokenWriter.view());
    ack.write(std::int32_t{0});
    ack.write(number + 1);
    ack.write(std::uint32_t{0});
    ack.write(std::uint32_t{1});
    EXPECT_TRUE(encode_reply(two, to_b, ack.take()));
    two.b.clock.advance(seconds(310));
  }
  void send_own(const EntityId& local, const EntityId& remote, std::span<const spi::Token> tokens,
                std::string_view class_id) {
    const auto payload = token_message({kOurs, local}, {kPeer, remote}, tokens, class_id);
    const auto octets = DataMessage{.number = 1, .payload = payload}.octets();
    EXPECT_TRUE(into_bytes(octets.size() + spi::protection_overhead(1), [&](MutableBytes out) {
      return two.b.transform().encode_datawriter_submessage(own.writer, {&own.reader, 1}, octets,
                                                            out);
    }));
  }
  bool is_stranded() {
    bool is = false;
    for (int i = 0; i < 25; ++i) {
      two.b.clock.advance(seconds(1));
      is |= two.b.factory().poll_stranded_keys({8});
    }
    return is;
  }

  TwoSides two;
  WriterToReader to_b;
  OwnWriter own;
  std::uint32_t number = 0;
};

TEST(AwaitedTokensTest, AReaderThatSendsItsTokens_WaitsForThoseOfTheWriter) {
  Receiver receiver;
  const auto user =
      receiver.two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  receiver.drop_ticket(kWriter, kReader, receiver.two.writer_tokens(user).value(), kOfWriter);
  EXPECT_FALSE(receiver.is_stranded());
  receiver.send_own(kReader, kWriter, receiver.two.reader_tokens(user).value(), kOfReader);
  EXPECT_TRUE(receiver.is_stranded());
  EXPECT_FALSE(receiver.is_stranded()) << "once";
}

// Each exchange of a subject awaits tokens of endpoints that it invented.
TEST(AwaitedTokensTest, OneSubject_LeavesRoomForAnother) {
  AwaitedTokens awaited;
  const auto await = [&](std::uint8_t subject, std::uint64_t exchange, std::uint32_t endpoint) {
    TokenKey key{{kPeer, kWriter}, {kOurs, kReader}};
    key.remote.prefix.octets[0] = subject;
    for (std::size_t i = 0; i < 3; ++i)
      key.remote.entity.octets[i] = static_cast<std::uint8_t>(endpoint >> 8 * i);
    awaited.await(exchange, key, seconds(1));
    return awaited.contains(exchange, key);
  };
  for (std::uint32_t i = 0; i < AwaitedTokens::kMaxOfSubject; ++i) ASSERT_TRUE(await(1, i % 4, i));
  EXPECT_FALSE(await(1, 5, AwaitedTokens::kMaxOfSubject));
  EXPECT_TRUE(await(2, 6, 0));
  awaited.end(3);
  EXPECT_TRUE(await(1, 5, AwaitedTokens::kMaxOfSubject));
}

// Such a peer would not notice that we restart the session.
TEST(AwaitedTokensTest, PeerWithOtherPlugins_StrandsNothing) {
  Receiver receiver(spi::kStandardCiphers);
  const auto user =
      receiver.two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  receiver.drop_ticket(kWriter, kReader, receiver.two.writer_tokens(user).value(), kOfWriter);
  receiver.send_own(kReader, kWriter, receiver.two.reader_tokens(user).value(), kOfReader);
  EXPECT_FALSE(receiver.is_stranded());
}

// If a writer protects payloads only, the host never brings tokens of readers for it.
TEST(AwaitedTokensTest, AWriter_WaitsOnlyIfItProtectsSubmessages) {
  for (const auto submessage : {ProtectionKind::none, ProtectionKind::sign}) {
    Receiver receiver;
    receiver.writer(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
    const auto ours = receiver.writer(endpoint_attributes(submessage, ProtectionKind::encrypt));
    const auto tokens = receiver.two.b.exchange()
                            .create_local_datawriter_crypto_tokens(ours.writer, ours.reader)
                            .value();
    receiver.drop_ticket(kReader, kWriter, tokens, kOfReader);
    receiver.send_own(kWriter, kReader, tokens, kOfWriter);
    EXPECT_EQ(receiver.is_stranded(), submessage != ProtectionKind::none);
  }
}

}  // namespace
}  // namespace ddssec::cryptography
