// The token ledger in the plugin: what a host that does not check sources gets of key token
// messages.
#include "plugins/cryptography/kept_tokens.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "base/writer.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/trusting_host.hpp"
#include "tests/unit/cryptography/two_sides.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography::trusting_host {
namespace {

using namespace testing;

// The host would pass such a message on to each of its participants.
TEST(TrustingHost, TokensThatReachAllItsParticipants_AreRefused) {
  for (const bool host_checks : {false, true}) {
    Receiver receiver(host_checks);
    auto& [a, b] = receiver.two;
    const auto message =
        DataMessage{.payload = token_message({kPeer, kWriter}, {kOurs, kReader}, fresh_tokens())}
            .octets();
    const auto encoded = encode_submessage(receiver.two, receiver.ends, message).value();
    EXPECT_TRUE(b.transform().preprocess_secure_submessage(b.participant, b.remote, encoded));
    EXPECT_EQ(code_of(b.transform().preprocess_secure_submessage({}, b.remote, encoded)),
              host_checks ? Code{} : Code::key_exchange_undirected);
  }
}

TEST(TrustingHost, TokensForAnotherOfItsParticipants_AreRefused) {
  Receiver receiver(false);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  const auto meet_as = [&](const GuidPrefix& own, std::uint8_t seed) {
    receiver.own = own;
    receiver.authenticate(seed);
    receiver.two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  };
  meet_as(kOurs, 6);
  EXPECT_TRUE(receiver.passes(1, tokens));
  meet_as(kVictim, 7);
  EXPECT_FALSE(receiver.passes(2, tokens));
  EXPECT_EQ(receiver.two.b.events.codes().back(), Code::token_source_mismatch);
}

TEST(TrustingHost, TokensInPlaceOfTickets_AreTakenOnce) {
  Receiver receiver(false);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  const auto first = receiver.decoded(1, tokens);
  EXPECT_EQ(receiver.decoded(1, tokens), first);
  const auto ticket = Receiver::tokens_in(first);
  EXPECT_NE(ticket, tokens);
  EXPECT_FALSE(std::ranges::search(first, tokens[0].binary_properties[0].value).size())
      << "key material in the host's memory";
  EXPECT_FALSE(receiver.passes(2, tokens));
  EXPECT_TRUE(receiver.two.take_writer(receiver.user, ticket));
  EXPECT_TRUE(receiver.passes(3, tokens));
  EXPECT_EQ(code_of(receiver.two.take_writer(receiver.user, ticket)),
            Code::key_material_kind_unknown)
      << "it is used, and no key material";
}

TEST(TrustingHost, HiddenContent_HasAClassThatTheHostDoesNotKnow) {
  Receiver receiver(false);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  EXPECT_TRUE(receiver.passes(1, tokens));
  const auto hidden = receiver.decoded(2, tokens);
  EXPECT_EQ(hidden[24 + 104], '-');
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector{Code::crypto_tokens_repeated});
  EXPECT_FALSE(std::ranges::search(hidden, tokens[0].binary_properties[0].value).size());
}

// The host did not use the ticket before its peer was gone. It uses it when the peer is back, and
// never asks for what comes after it.
TEST(TrustingHost, TicketOfAFormerSession_StillBringsKeys) {
  Receiver receiver(false);
  const auto former =
      Receiver::tokens_in(receiver.decoded(1, receiver.two.writer_tokens(receiver.user).value()));
  receiver.authenticate(6);
  auto& [a, b] = receiver.two;
  receiver.user.remote_reader = a.factory()
                                    .register_matched_remote_datareader(
                                        receiver.user.writer, a.remote, shared_secret(6), false)
                                    .value();
  receiver.user.remote_writer =
      b.factory()
          .register_matched_remote_datawriter(receiver.user.reader, b.remote, shared_secret(6))
          .value();
  EXPECT_TRUE(receiver.two.take_writer(receiver.user, former)) << "or the host drops the match";
  const auto message = DataMessage{.writer = kWriter, .number = 1}.octets();
  const auto encoded = encode_submessage(receiver.two, receiver.user, message).value();
  EXPECT_EQ(code_of(decode_submessage(receiver.two, receiver.user, encoded)),
            Code::key_material_not_received);
  EXPECT_FALSE(receiver.passes(2, receiver.two.writer_tokens(receiver.user).value()));
  const auto next = encode_submessage(receiver.two, receiver.user, message).value();
  EXPECT_TRUE(decode_submessage(receiver.two, receiver.user, next));
}

// Returns an ACKNACK of the volatile reader in one byte order.
Bytes acknowledgement(std::uint32_t next, bool little) {
  Writer out(little ? Endian::little : Endian::big, 32);
  out.write(std::uint8_t{0x06});
  out.write(static_cast<std::uint8_t>(little ? 1 : 0));
  out.write(std::uint16_t{24});
  out.write_bytes(rtps::kVolatileMessageReader.view());
  out.write_bytes(rtps::kVolatileMessageWriter.view());
  out.write(std::int32_t{0});
  out.write(next);
  out.write(std::uint32_t{0});
  out.write(std::uint32_t{1});
  return out.take();
}

// Until then the host passes the message on by another participant's reader. It would do so again
// when the sender repeats the message.
TEST(TrustingHost, TokensBeforeItsReaderSpeaks_AreNotAccepted) {
  for (const bool host_checks : {false, true}) {
    Receiver receiver(host_checks);
    const auto tokens = receiver.two.writer_tokens(receiver.user).value();
    receiver.authenticate(6, false);
    const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens);
    const auto message = DataMessage{.number = 1, .payload = payload}.octets();
    const auto receive = [&] {
      return decode_submessage(receiver.two, receiver.ends,
                               encode_submessage(receiver.two, receiver.ends, message).value());
    };
    EXPECT_EQ(code_of(receive()), host_checks ? Code{} : Code::crypto_tokens_early);
    EXPECT_EQ(receiver.two.b.events.codes(), std::vector<Code>()) << "no peer is to blame";
    EXPECT_TRUE(encode_reply(receiver.two, receiver.ends, acknowledgement(1, true)));
    EXPECT_TRUE(receive());
  }
}

// The host drops tokens for an endpoint that it does not have. Such an endpoint may come later.
TEST(TrustingHost, TokensTakenSixMinutesAgo_ComeAgain) {
  for (const bool little : {true, false}) {
    Receiver receiver(false);
    const auto tokens = receiver.two.writer_tokens(receiver.user).value();
    EXPECT_TRUE(receiver.passes(1, tokens));
    EXPECT_TRUE(encode_reply(receiver.two, receiver.ends, acknowledgement(2, little)));
    EXPECT_FALSE(receiver.passes(2, tokens));
    EXPECT_TRUE(encode_reply(receiver.two, receiver.ends, acknowledgement(3, little)));
    receiver.two.b.clock.advance(TokenLedger::kMemory + std::chrono::seconds(10));
    const auto again = receiver.decoded(3, tokens);
    EXPECT_TRUE(receiver.two.take_writer(receiver.user, Receiver::tokens_in(again)));
  }
}

// The host may hold a message back until a missing one arrives.
TEST(TrustingHost, TokensBeforeTheAcknowledgment_DoNotComeAgain) {
  Receiver receiver(false);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  EXPECT_TRUE(receiver.passes(2, tokens));
  EXPECT_TRUE(encode_reply(receiver.two, receiver.ends, acknowledgement(2, true)));
  receiver.two.b.clock.advance(2 * TokenLedger::kMemory);
  EXPECT_FALSE(receiver.passes(3, tokens));
}

// The host would hold such tokens for nothing. An event names the sender only if no honest sender
// does this.
TEST(TrustingHost, TokensThatNothingHereCanUse_AreRefused) {
  Receiver receiver(false);
  auto tokens = receiver.two.writer_tokens(receiver.user).value();
  const auto to_nobody = [&](const EntityId& remote, const EntityId& local,
                             std::string_view class_id) {
    static std::uint32_t number = 100;
    const auto payload = token_message({kPeer, remote}, {kOurs, local}, tokens, class_id);
    const auto octets = DataMessage{.number = ++number, .payload = payload}.octets();
    const auto out =
        decode_submessage(receiver.two, receiver.ends,
                          encode_submessage(receiver.two, receiver.ends, octets).value());
    return out.value()[24 + 104] == '-';
  };
  EXPECT_TRUE(to_nobody(kReader, kWriter, "dds.sec.datareader_crypto_tokens"))
      << "no writer is here";
  EXPECT_TRUE(
      to_nobody({{0xff, 0, 3, 0xc7}}, {{0xff, 0, 3, 0xc2}}, "dds.sec.datareader_crypto_tokens"));
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector<Code>());
  EXPECT_TRUE(to_nobody({{0xfe, 0, 3, 0xc2}}, {{0xff, 0, 3, 0xc7}}, kOfWriter));
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector{Code::token_source_unreadable});
  tokens[0].properties.emplace_back();
  EXPECT_TRUE(to_nobody(kWriter, kReader, kOfWriter));
  EXPECT_EQ(receiver.two.b.events.codes().back(), Code::crypto_token_form);
}

// A refused message would be missing, and would hold up all messages after it.
TEST(TrustingHost, FullLedger_LetsWhatFollowsPass) {
  Receiver receiver(false);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  const auto passes = [&](std::uint32_t number, std::string_view class_id) {
    EntityId invented = kWriter;
    for (std::size_t i = 0; i < 3; ++i)
      invented.octets[i] = static_cast<std::uint8_t>(number >> (16 - 8 * i));
    const auto payload = token_message({kPeer, invented}, {kOurs, kReader}, tokens, class_id);
    const auto octets = DataMessage{.number = number, .payload = payload}.octets();
    const auto out =
        decode_submessage(receiver.two, receiver.ends,
                          encode_submessage(receiver.two, receiver.ends, octets).value());
    EXPECT_TRUE(out);
    return out.value()[24 + 104] == 'd';
  };
  std::uint32_t number = 0;
  while (number < TokenLedger::kMaxPending) ASSERT_TRUE(passes(++number, kOfWriter));
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector<Code>());
  EXPECT_FALSE(passes(++number, kOfWriter));
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector{Code::crypto_tokens_crowded});
  EXPECT_TRUE(passes(++number, kOfParticipant)) << "there is room for what all else depends on";
}

TEST(CheckingHost, RepeatedTokens_PassToAHostThatChecks) {
  Receiver receiver(true);
  const auto tokens = receiver.two.writer_tokens(receiver.user).value();
  EXPECT_EQ(Receiver::tokens_in(receiver.decoded(1, tokens)), tokens);
  EXPECT_EQ(Receiver::tokens_in(receiver.decoded(2, tokens)), tokens);
}

}  // namespace
}  // namespace ddssec::cryptography::trusting_host
