// The wire form of every message: cut anywhere, it is refused by the token reader. And what a host
// learns about a message before it does any work.
#include <gmock/gmock.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

class Truncation : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Messages, Truncation, testing::Values("Req", "Reply", "Final", "AuthReq"));

TEST_P(Truncation, MessageCutAtAnyOctet_IsRefused) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  const std::map<std::string, Token> tokens = {{"Req", *request->message},
                                               {"Reply", *reply->message},
                                               {"Final", *final_message->message},
                                               {"AuthReq", sample()}};
  for (const auto endian : {Endian::little, Endian::big}) {
    Writer writer(endian);
    spi::write_token(writer, tokens.at(GetParam()));
    for (std::size_t size = 0; size < writer.size(); ++size) {
      Reader reader(writer.view().first(size), endian);
      EXPECT_THAT(test::code_of(spi::read_token(reader)),
                  testing::AnyOf(Code::truncated, Code::length_out_of_range))
          << size;
    }
    Reader reader(writer.view(), endian);
    EXPECT_EQ(*spi::read_token(reader), tokens.at(GetParam()));
  }
}

using Kind = spi::Authentication::Outline::Kind;

TEST(Outline, EachMessage_SaysWhatItIsAndAnswers) {
  Pairing pairing;
  auto& plugin = *pairing.two.low.plugin;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final);
  const auto first = plugin->outline(*request->message);
  const auto second = plugin->outline(*reply->message);
  const auto third = plugin->outline(*final->message);
  EXPECT_EQ(first.kind, Kind::request);
  EXPECT_EQ(second.kind, Kind::reply);
  EXPECT_EQ(third.kind, Kind::final);
  EXPECT_EQ(to_bytes(first.participant_data), pairing.two.low.data);
  EXPECT_EQ(to_bytes(second.participant_data), pairing.two.high.data);
  EXPECT_FALSE(first.challenge1.empty());
  EXPECT_TRUE(first.challenge2.empty());
  EXPECT_TRUE(std::ranges::equal(first.challenge1, second.challenge1));
  EXPECT_TRUE(std::ranges::equal(second.challenge2, third.challenge2));
}

// The host still passes such messages on, so that the plugin says why it refuses them.
TEST(Outline, AnotherPluginsMessage_GoesByTheEndOfItsClass) {
  Pairing pairing;
  auto& plugin = *pairing.two.low.plugin;
  EXPECT_EQ(plugin->outline({"com.example:9.9+Req"}).kind, Kind::request);
  for (const auto* other : {"", "DDS:Auth:PKI-DH:1.0", "DDS:Auth:PKI-DH:1.0+AuthReq", "+Requ"})
    EXPECT_EQ(plugin->outline({other}).kind, Kind::other) << other;
}

}  // namespace
}  // namespace ddssec::authentication
