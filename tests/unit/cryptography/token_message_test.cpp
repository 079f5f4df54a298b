#include "tests/unit/cryptography/token_message.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr EntityId kWriter{{0, 0, 1, 2}}, kReader{{0, 0, 1, 7}};

Status usable(const EntityId& remote, const EntityId& local, bool is_of_reader,
              std::vector<spi::Token> tokens = {Insider(kAes256Gcm).token()}) {
  return check_usable({{kPeer, remote}, {kOurs, local}, 1, is_of_reader, std::move(tokens), 0, 0});
}

// The host never matches other pairs, so it would still hold their ticket when the next one
// arrives.
TEST(UsableTokens, OnlyEndpointsThatExchangeKeys_AreAccepted) {
  constexpr EntityId kSecureWriter{{0xff, 0, 3, 0xc2}}, kSecureReader{{0xff, 0, 3, 0xc7}};
  EXPECT_TRUE(usable(kWriter, kReader, false));
  EXPECT_TRUE(usable(kReader, kWriter, true));
  EXPECT_TRUE(usable(kSecureWriter, kSecureReader, false));
  EXPECT_TRUE(usable(kSecureReader, kSecureWriter, true));
  EXPECT_TRUE(usable(kEntityIdParticipant, kEntityIdParticipant, false));
  constexpr std::array<std::pair<EntityId, EntityId>, 10> kPairs = {{
      {{{0xfe, 0, 1, 0xc2}}, kSecureReader},
      {{{0xff, 0, 4, 0xc2}}, kSecureReader},
      {kSecureReader, kSecureReader},
      {kSecureWriter, {{0, 0, 1, 0x07}}},
      {{{0, 0, 1, 0x02}}, kSecureReader},
      {kEntityIdParticipant, kSecureReader},
      {kWriter, kWriter},
      {kReader, kReader},
      {{{0, 0, 1, 0x08}}, kReader},
      {kWriter, kEntityIdParticipant},
  }};
  for (const auto& [remote, local] : kPairs)
    for (const bool is_of_reader : {false, true})
      EXPECT_EQ(code_of(usable(remote, local, is_of_reader)), Code::token_source_unreadable)
          << remote.to_string() << local.to_string();
  EXPECT_EQ(code_of(usable(kWriter, kReader, true)), Code::token_source_unreadable);
  EXPECT_EQ(code_of(usable(kReader, kWriter, false)), Code::token_source_unreadable);
}

TEST(UsableTokens, OtherThanKeyMaterial_IsRefused) {
  const auto token = Insider(kAes256Gcm).token();
  const auto of_writer = [](std::vector<spi::Token> tokens) {
    return code_of(usable(kWriter, kReader, false, std::move(tokens)));
  };
  EXPECT_EQ(of_writer({token, token}), Code{});
  EXPECT_EQ(of_writer({token, token, token}), Code::crypto_token_count);
  EXPECT_EQ(of_writer({}), Code::crypto_token_count);
  EXPECT_EQ(code_of(usable(kEntityIdParticipant, kEntityIdParticipant, false, {token, token})),
            Code::crypto_token_count);
  auto stuffed = token;
  stuffed.properties.emplace_back();
  EXPECT_EQ(of_writer({stuffed}), Code::crypto_token_form);
  stuffed = token;
  stuffed.binary_properties.emplace_back();
  EXPECT_EQ(of_writer({token, stuffed}), Code::crypto_token_form);
  auto renamed = token;
  renamed.class_id += ' ';
  EXPECT_EQ(of_writer({renamed}), Code::crypto_token_class);
  auto shortened = token;
  shortened.binary_properties[0].value.resize(15);
  EXPECT_EQ(of_writer({shortened}), Code::key_material_length);
}

std::optional<TokenMessage> read(const Bytes& payload) {
  const auto octets = DataMessage{.number = 9, .payload = payload}.octets();
  const auto piece = read_data_piece(octets);
  return read_token_message(*piece).value();
}

TEST(TokenMessage, EachMessage_NamesTheOwnerAndTheReceiverOfItsTokens) {
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
      EXPECT_EQ(message->tokens, tokens);
      EXPECT_EQ(payload[message->class_at], 'd');
    }
    const auto message = read(token_message(remote, local, tokens, kOfParticipant, little));
    ASSERT_TRUE(message);
    EXPECT_EQ(message->remote, (Guid{kPeer, kEntityIdParticipant}));
    EXPECT_EQ(message->local, (Guid{kOurs, kEntityIdParticipant}));
    EXPECT_FALSE(read(token_message(remote, local, tokens, "dds.sec.auth", little)));
  }
}

TEST(TokenMessage, NumberThatCycloneTakesFirst_IsRefused) {
  const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, fresh_tokens());
  auto octets = DataMessage{.payload = payload}.octets();
  auto piece = read_data_piece(octets).value();
  piece.number = kMaxNumber;
  EXPECT_EQ(code_of(read_token_message(piece)), Code::token_source_unreadable);
}

TEST(TokenMessage, MoreThanKeys_IsRefused) {
  auto tokens = fresh_tokens();
  tokens[0].binary_properties[0].value.resize(kMaxTokenOctets + 1);
  const auto octets =
      DataMessage{.payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens)}.octets();
  EXPECT_EQ(code_of(read_token_message(read_data_piece(octets).value())),
            Code::token_source_unreadable);
}

TEST(TokenMessage, MessageCutOffAnywhere_IsRefused) {
  const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, fresh_tokens());
  for (std::size_t size = 100; size + 4 < payload.size(); ++size) {
    const auto octets =
        DataMessage{.payload = Bytes(payload.begin(), payload.begin() + static_cast<long>(size))}
            .octets();
    const auto piece = read_data_piece(octets);
    EXPECT_EQ(code_of(read_token_message(*piece)), Code::token_source_unreadable) << size;
  }
}

}  // namespace
}  // namespace ddssec::cryptography
