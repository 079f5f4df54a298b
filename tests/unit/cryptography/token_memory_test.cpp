// The memory that key tokens cost if no endpoint ever comes for them.
#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

// docs/threat-model.md: for each certificate.
constexpr std::int64_t kMaxOctets = 16'000'000;
constexpr auto kOriginAuthenticated = ProtectionKind::encrypt_with_origin_authentication;

// Authenticates as several participants of one certificate, and sends key tokens to `b`.
struct TokenSender {
  TokenSender() {
    reader = two.endpoints(endpoint_attributes(kOriginAuthenticated, ProtectionKind::encrypt));
    tokens = two.writer_tokens(reader).value();
    EXPECT_EQ(tokens.size(), kMaxTokensPerEndpoint);
  }
  // From now on the sender is the participant of this number.
  void authenticate(std::uint8_t number) {
    prefix.octets.back() = number;
    auto secret = shared_secret(number);
    for (auto* side : {&two.a, &two.b}) {
      // A hostile sender does not check which participant its key tokens are for.
      if (side == &two.b) secret.peer_prefix = prefix;
      side->remote =
          side->factory()
              .register_matched_remote_participant(side->participant, {number + 10}, {7}, secret)
              .value();
    }
    exchange = two.volatile_endpoints();
  }
  // Sends tokens of the n-th writer, which `b` never hears of otherwise. True if they were kept.
  bool send(std::uint32_t n) {
    const EntityId writer{{static_cast<std::uint8_t>(n >> 16), static_cast<std::uint8_t>(n >> 8),
                           static_cast<std::uint8_t>(n), 2}};
    const auto payload = token_message({prefix, writer}, {kOurs, {{0, 0, 1, 7}}}, tokens);
    const auto octets = DataMessage{.number = n, .payload = payload}.octets();
    const auto passed =
        decode_submessage(two, exchange, encode_submessage(two, exchange, octets).value());
    return passed && (*passed)[24 + 104] == 'd';
  }

  TwoSides two{ProtectionKind::none, {}, {.host_checks_sources = false}};
  WriterToReader reader, exchange;
  std::vector<spi::Token> tokens;
  GuidPrefix prefix = kPeer;
};

TEST(KeyTokensOfOneCertificate, FullLedger_TakesNoMoreThanThePromisedMemory) {
  TokenSender sender;
  sender.authenticate(1);
  ASSERT_TRUE(sender.send(1));
  const auto before = counted_memory::octets();
  std::uint32_t sent = 1;
  for (std::uint8_t participant = 1; participant <= 4; ++participant) {
    if (participant > 1) sender.authenticate(participant);
    for (std::size_t i = 0; i < TokenLedger::kMaxPending / 4; ++i) sender.send(++sent);
  }
  EXPECT_FALSE(sender.send(++sent)) << "that was the bound";
  const auto held = counted_memory::octets() - before;
  EXPECT_LE(held, kMaxOctets);
  EXPECT_GE(held, kMaxOctets / 4) << "they were not kept: this measures nothing";
  RecordProperty("octets", static_cast<int>(held));
}

// A host would store any token. Otherwise each message could hold memory for its empty properties.
TEST(KeyTokensOfOneCertificate, TokensWithMoreThanAKeyNeeds_AreRefusedAndTakeNoMemory) {
  TokenSender sender;
  sender.authenticate(1);
  ASSERT_TRUE(sender.send(1)) << "without the properties they are kept";
  auto& events = sender.two.b.events;
  sender.tokens[0].properties.resize(10);
  const auto before = counted_memory::octets();
  for (std::uint32_t n = 2; n <= 300; ++n) {
    ASSERT_FALSE(sender.send(n)) << n;
    ASSERT_EQ(events.codes(), std::vector{Code::crypto_token_form}) << n;
    events.all = {};
  }
  EXPECT_LT(counted_memory::octets() - before, 10'000);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
