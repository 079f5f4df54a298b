#include "plugins/cryptography/token_ledger.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;
using std::chrono::seconds;

constexpr EntityId kWriter{{0, 0, 1, 2}}, kReader{{0, 0, 1, 7}}, kOtherReader{{0, 0, 2, 7}};

using Kind = TokenDecision::Kind;

// A host: messages arrive, and it comes back with the tokens in them.
struct Host {
  Guid remote{kPeer, kWriter};
  Guid local{kOurs, kReader};
  std::uint64_t exchange = 1;
  bool are_matched = false;
  TokenLedger ledger;
  std::chrono::nanoseconds now = seconds(1000);
  Ticket ticket = {};
  std::vector<spi::Token> sent = {};

  // A message arrives with tokens that differ from all before.
  Kind note(std::uint64_t number) {
    sent = fresh_tokens();
    const auto passage =
        ledger.note({remote, local, number, false, sent, 0, 0}, {exchange}, are_matched, now)
            .value();
    if (passage.kind == Kind::ticket) ticket = passage.ticket;
    return passage.kind;
  }
  static std::vector<spi::Token> with(const Ticket& ticket) {
    auto tokens = fresh_tokens();
    auto& value = tokens[0].binary_properties.at(0).value;
    std::ranges::fill(value, std::uint8_t{0});
    std::ranges::copy(ticket.octets, value.begin());
    return tokens;
  }
  std::optional<TokenLedger::StoredTokens> use(const Ticket& ticket) {
    return ledger.redeem(with(ticket), {});
  }
  bool use() { return use(ticket).has_value(); }
};

TEST(TokenLedger, OneTicket_GivesItsTokensOnce) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  const auto held = host.use(host.ticket);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->remote, host.remote);
  EXPECT_EQ(held->tokens, host.sent);
  EXPECT_FALSE(host.use());
}

TEST(TokenLedger, ASecondMessage_IsHiddenAndItsTokensCount) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_EQ(host.note(2), Kind::repeated);
  EXPECT_EQ(host.note(4), Kind::repeated);
  const auto newest = host.sent;
  EXPECT_EQ(host.note(3), Kind::repeated);
  EXPECT_EQ(host.use(host.ticket)->tokens, newest);
  EXPECT_EQ(host.note(4), Kind::hidden) << "the host passed it over";
  EXPECT_EQ(host.note(5), Kind::ticket);
}

TEST(TokenLedger, OnlyTheMessageThatPassed_PassesAgain) {
  Host host;
  EXPECT_EQ(host.note(5), Kind::ticket);
  const auto first = host.ticket;
  const auto tokens = host.sent;
  EXPECT_EQ(host.note(5), Kind::ticket);
  EXPECT_EQ(host.ticket, first);
  EXPECT_EQ(host.note(4), Kind::repeated) << "the host would take it, and then 5";
  EXPECT_EQ(host.use(first)->tokens, tokens) << "whatever the repetition says";
  EXPECT_EQ(host.note(5), Kind::hidden);
  EXPECT_EQ(host.note(4), Kind::hidden) << "the host never saw it, and takes none before 5";
}

// A great number, which the host may never see, must not let lower ones pass.
TEST(TokenLedger, AGreatNumber_OpensNothing) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_TRUE(host.use());
  EXPECT_EQ(host.note(kMaxNumber - 1), Kind::ticket);
  for (std::uint64_t number = 2; number < 50; ++number)
    EXPECT_EQ(host.note(number), Kind::repeated);
}

TEST(TokenLedger, NewAuthentication_ForgetsTheParticipantsTicket) {
  Host host;
  host.remote.entity = host.local.entity = kEntityIdParticipant;
  EXPECT_EQ(host.note(1), Kind::ticket);
  const auto former = host.ticket;
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_FALSE(host.use(former));
  EXPECT_TRUE(host.use());
}

TEST(TokenLedger, NewSession_WaitsUntilTheHostHasMatchedBuiltinEndpoints) {
  Host host;
  host.remote.entity = {{0xff, 0, 3, 0xc2}};
  host.local.entity = {{0xff, 0, 3, 0xc7}};
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::later);
  host.now += seconds(1);
  host.are_matched = true;
  EXPECT_EQ(host.note(1), Kind::later) << "the host may be coming";
  host.now += TokenLedger::kComing;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_TRUE(host.use());
}

TEST(TokenLedger, FormerTicketOfBuiltinEndpoints_EndsTheWait) {
  Host host;
  host.remote.entity = {{0xff, 0, 3, 0xc2}};
  host.local.entity = {{0xff, 0, 3, 0xc7}};
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::later);
  EXPECT_TRUE(host.use());
  EXPECT_EQ(host.note(1), Kind::ticket);
}

TEST(TokenLedger, AFormerTicketOfOtherEndpoints_GetsTheNewTokens) {
  Host host;
  EXPECT_EQ(host.note(7), Kind::ticket);
  host.exchange = 2;
  host.are_matched = true;
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_EQ(host.use(host.ticket)->tokens, host.sent);
}

// The host may hold messages back until a missing one arrives.
TEST(TokenLedger, TokensWithoutAcknowledgment_AreNotForgotten) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.now += 10 * TokenLedger::kMemory;
  EXPECT_EQ(host.note(2), Kind::repeated);
}

// If the tokens are for a local endpoint that does not exist, the host drops them without a report.
TEST(TokenLedger, TakenAndUnusedTokens_AreForgotten) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.acknowledged(1, 2, host.now);
  host.now += TokenLedger::kMemory;
  EXPECT_EQ(host.note(2), Kind::repeated) << "it may hold the ticket still";
  host.now += seconds(10);
  EXPECT_EQ(host.note(3), Kind::ticket) << "an endpoint that was made later gets its keys";
  EXPECT_EQ(host.use(host.ticket)->tokens, host.sent);
  EXPECT_EQ(host.ledger.size(), 1u);
}

TEST(TokenLedger, WhatTheHostMayNotHaveTaken_IsNotForgotten) {
  Host host;
  EXPECT_EQ(host.note(2), Kind::ticket);
  for (int i = 0; i < 100; ++i) host.ledger.acknowledged(1, 2, host.now += seconds(10));
  EXPECT_EQ(host.note(3), Kind::repeated);
}

// Acknowledgments within ten seconds are counted from the last one.
TEST(TokenLedger, AcknowledgmentOfTheMessage_StartsTheTime) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  const Guid other{kOurs, kOtherReader};
  EXPECT_TRUE(
      host.ledger.note({host.remote, other, 9, false, fresh_tokens(), 0, 0}, {1}, false, host.now));
  host.ledger.acknowledged(1, 2, host.now);
  host.ledger.acknowledged(1, 9, host.now += seconds(9));
  host.ledger.acknowledged(1, 10, host.now += seconds(1));
  host.now += TokenLedger::kMemory;
  host.ledger.acknowledged(1, 10, host.now);
  EXPECT_EQ(host.ledger.pending(), 1u);
  host.now += seconds(10);
  host.ledger.acknowledged(1, 10, host.now);
  EXPECT_EQ(host.ledger.pending(), 0u);
}

// Otherwise a stranger could repeat a recorded message, and the tokens would wait for another six
// minutes.
TEST(TokenLedger, WhatTheHostHasTaken_MakesNothingWait) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.acknowledged(1, 2, host.now);
  host.now += TokenLedger::kMemory + seconds(10);
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_EQ(host.note(2), Kind::ticket);
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_EQ(host.use(host.ticket)->tokens.size(), 1u);
}

TEST(TokenLedger, WhatTheHostUsed_IsRememberedWhenItIsAcknowledged) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_TRUE(host.use());
  host.ledger.acknowledged(1, 2, host.now);
  host.now += 2 * TokenLedger::kMemory;
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_EQ(host.ledger.size(), 1u);
}

TEST(TokenLedger, AcknowledgmentsOfEndedExchanges_LeaveNothing) {
  Host host;
  for (std::uint64_t exchange = 1; exchange < 100; ++exchange) {
    host.exchange = exchange;
    EXPECT_NE(host.note(exchange), Kind::later);
    host.ledger.acknowledged(exchange, exchange + 1, host.now);
    host.ledger.end(exchange, host.now);
    host.now += TokenLedger::kMemory;
  }
  host.ledger.acknowledged(200, 7, host.now += seconds(10));
  EXPECT_EQ(host.ledger.size(), 0u);
}

TEST(TokenLedger, AnExchangeWithoutTokens_LeavesNothing) {
  Host host;
  for (std::uint64_t exchange = 2; exchange < 1000; ++exchange) host.ledger.end(exchange, host.now);
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.end(1, host.now);
  host.now += TokenLedger::kMemory;
  host.ledger.end(2, host.now);
  EXPECT_EQ(host.ledger.size(), 0u);
}

TEST(TokenLedger, SixMinutesAfterItsEnd_TheHostHoldsNothing) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.end(host.exchange, host.now);
  host.exchange = 2;
  host.now += TokenLedger::kMemory - seconds(1);
  EXPECT_EQ(host.note(2), Kind::hidden);
  host.now += seconds(1);
  EXPECT_EQ(host.note(3), Kind::ticket);
  EXPECT_EQ(host.ledger.size(), 1u);
}

TEST(TokenLedger, OtherEndpoints_AreOthersWhateverTheirTokens) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  const auto first = host.ticket;
  const auto tokens = host.sent;
  host.local.entity = kOtherReader;
  EXPECT_EQ(
      host.ledger.note({host.remote, host.local, 2, false, tokens, 0, 0}, {1}, false, host.now)
          ->kind,
      Kind::ticket);
  host.remote.prefix = kVictim;
  EXPECT_EQ(
      host.ledger.note({host.remote, host.local, 3, false, tokens, 0, 0}, {2}, false, host.now)
          ->kind,
      Kind::ticket);
  EXPECT_EQ(host.use(first)->remote, (Guid{kPeer, kWriter}));
  host.remote.prefix = kPeer;
  host.local.entity = kReader;
  EXPECT_EQ(host.note(4), Kind::ticket) << "the others' tickets are none of its business";
}

TEST(TokenLedger, TokensOfAFormerSession_AreNotGivenToThePresentOne) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  const TicketUser user{.exchange = 2, .local = 20, .remote = 30};
  const auto former = host.ledger.redeem(Host::with(host.ticket), user);
  ASSERT_TRUE(former);
  EXPECT_TRUE(former->tokens.empty());
  EXPECT_FALSE(host.use());
  host.exchange = 2;
  const auto tokens = fresh_tokens();
  const auto passage =
      host.ledger.note({host.remote, host.local, 2, false, tokens, 0, 0}, {2}, false, host.now)
          .value();
  EXPECT_EQ(passage.kind, Kind::awaited);
  EXPECT_EQ(passage.user, user);
  EXPECT_EQ(host.ledger.redeem(Host::with(passage.ticket), user)->tokens, tokens);
  EXPECT_EQ(host.note(3), Kind::ticket) << "once";
}

// The message was opened, but the host dropped the peer before it took the message.
TEST(TokenLedger, TokensBehindATicketThatTheHostNeverHad_AreToComeAgain) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.end(1, host.now);
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::hidden);
  host.ledger.end(2, host.now);
  host.exchange = 3;
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_FALSE(host.ledger.poll_stranded(3, host.now));
  host.now += TokenLedger::kMemory;
  EXPECT_TRUE(host.ledger.poll_stranded(3, host.now));
  EXPECT_FALSE(host.ledger.poll_stranded(3, host.now)) << "once";
  EXPECT_FALSE(host.ledger.poll_stranded(2, host.now));
  host.ledger.end(3, host.now);
  host.exchange = 4;
  EXPECT_EQ(host.note(1), Kind::ticket);
}

TEST(TokenLedger, WhatTheHostUsedOrWhatEnded_StrandsNothing) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.ledger.end(1, host.now);
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_TRUE(host.use());
  host.now += TokenLedger::kMemory;
  EXPECT_FALSE(host.ledger.poll_stranded(2, host.now));
  EXPECT_EQ(host.note(2), Kind::ticket);
  host.ledger.end(2, host.now);
  host.now += TokenLedger::kMemory;
  EXPECT_FALSE(host.ledger.poll_stranded(2, host.now)) << "it is over";
}

TEST(TokenLedger, ThoseOfALaterSession_AreNotForTheUserOfThisOne) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_TRUE(host.ledger.redeem(Host::with(host.ticket), {2, 20, 30})->tokens.empty());
  host.exchange = 3;
  EXPECT_EQ(host.note(1), Kind::ticket);
}

TEST(TokenLedger, TokensBeforeTheOldTicketIsUsed_Count) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  host.exchange = 2;
  EXPECT_EQ(host.note(1), Kind::hidden);
  EXPECT_EQ(host.ledger.redeem(Host::with(host.ticket), {2, 20, 30})->tokens, host.sent);
}

TEST(TokenLedger, WhatIsNoTicket_FindsNothing) {
  Host host;
  EXPECT_EQ(host.note(1), Kind::ticket);
  EXPECT_FALSE(host.ledger.redeem(fresh_tokens(), {}));
  EXPECT_FALSE(host.ledger.redeem({}, {}));
  EXPECT_EQ(host.note(2), Kind::repeated);
}

TEST(TokenLedger, OneCertificate_HasABoundedNumber) {
  Host host;
  const auto note = [&](std::size_t number) {
    host.remote.entity.octets[0] = static_cast<std::uint8_t>(number >> 16);
    host.remote.entity.octets[1] = static_cast<std::uint8_t>(number >> 8);
    host.remote.entity.octets[2] = static_cast<std::uint8_t>(number);
    return host.ledger.note({host.remote, host.local, number, false, fresh_tokens(), 0, 0}, {1},
                            false, host.now);
  };
  for (std::size_t i = 1; i <= TokenLedger::kMaxPending; ++i) {
    host.remote.prefix.octets[11] = static_cast<std::uint8_t>(i % 3);  // the participants change
    ASSERT_TRUE(note(i));
  }
  EXPECT_EQ(code_of(note(TokenLedger::kMaxPending + 1)), Code::crypto_tokens_crowded);
  EXPECT_EQ(host.ledger.size(), TokenLedger::kMaxPending);
  const Guid own{kOurs, kEntityIdParticipant}, peer{kPeer, kEntityIdParticipant};
  EXPECT_TRUE(host.ledger.note({peer, own, 1, false, fresh_tokens(), 0, 0}, {1}, false, host.now))
      << "what everything else depends on has room";
  host.remote.prefix = kVictim;
  EXPECT_TRUE(note(1));
  host.ledger.end(1, host.now);
  host.remote.prefix = kPeer;
  host.now += TokenLedger::kMemory;
  EXPECT_TRUE(note(1));
  EXPECT_EQ(host.ledger.size(), 1u);
}

// A sender that has proven no name invents a new one for each message.
class Inventor {
 public:
  Inventor(Host& host, std::uint64_t exchange) : host_(host), exchange_(exchange) {}

  Result<TokenDecision> note() {
    ++invented_;
    Guid remote{kPeer, kWriter};
    for (std::size_t i = 0; i < 8; ++i)
      remote.prefix.octets[i] = static_cast<std::uint8_t>(invented_ >> (8 * i));
    return host_.ledger.note({remote, host_.local, invented_, false, fresh_tokens(), 0, 0},
                             {exchange_, false}, false, host_.now);
  }
  std::size_t fill() {
    std::size_t count = 0;
    while (note()) ++count;
    return count;
  }

 private:
  Host& host_;
  const std::uint64_t exchange_;
  std::uint64_t invented_ = exchange_ << 32;
};

TEST(TokenLedger, OneThatInventsNames_HasABoundedNumber) {
  Host host;
  Inventor inventor(host, 1), honest(host, 2);
  EXPECT_EQ(inventor.fill(), TokenLedger::kMaxPending);
  EXPECT_EQ(code_of(inventor.note()), Code::crypto_tokens_crowded);
  EXPECT_TRUE(honest.note());
  host.exchange = 3;
  EXPECT_EQ(host.note(1), Kind::ticket) << "one that proved its name";
  host.ledger.end(1, host.now);
  host.now += TokenLedger::kMemory;
  EXPECT_TRUE(honest.note());
  EXPECT_EQ(host.ledger.size(), 3u);
}

TEST(TokenLedger, AllThatInventNames_HaveABoundedNumber) {
  Host host;
  constexpr std::uint64_t kInventors = 8;
  std::size_t all = 0;
  for (std::uint64_t exchange = 1; exchange <= kInventors; ++exchange) {
    Inventor inventor(host, exchange);
    const auto free = TokenLedger::kMaxUnproven - all;
    const auto some = inventor.fill();
    EXPECT_LE(some, TokenLedger::kMaxPending);
    EXPECT_LT(some, free);
    EXPECT_GT(some, 0u);
    all += some;
  }
  EXPECT_EQ(host.ledger.size(), all);
  host.exchange = kInventors + 1;
  EXPECT_EQ(host.note(1), Kind::ticket) << "one that proved its name";
}

// Uses four times as many tickets as may wait, each at once. Their senders differ in the octets of
// `name`.
void expect_used_ones_to_be_forgotten(Host& host, std::span<std::uint8_t, 3> name, bool is_proven) {
  for (std::uint64_t i = 1; i <= 4 * TokenLedger::kMaxPending; ++i) {
    name[0] = static_cast<std::uint8_t>(i >> 16);
    name[1] = static_cast<std::uint8_t>(i >> 8);
    name[2] = static_cast<std::uint8_t>(i);
    const auto passage = host.ledger.note({host.remote, host.local, i, false, fresh_tokens(), 0, 0},
                                          {1, is_proven}, false, host.now);
    ASSERT_EQ(passage->kind, Kind::ticket);
    ASSERT_TRUE(host.use(passage->ticket));
    ASSERT_LE(host.ledger.size(), 2 * TokenLedger::kMaxPending);
  }
}

TEST(TokenLedger, UsedOnesOfUnprovenNames_AreForgottenInTime) {
  Host host;
  expect_used_ones_to_be_forgotten(host, std::span(host.remote.prefix.octets).subspan<1, 3>(),
                                   false);
}

TEST(TokenLedger, UsedOnes_AreForgottenInTime) {
  Host host;
  expect_used_ones_to_be_forgotten(host, std::span(host.remote.entity.octets).first<3>(), true);
}

}  // namespace
}  // namespace ddssec::cryptography
